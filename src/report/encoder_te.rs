//! Transmission error from encoder records: document, table over the angle.

use std::f64::consts::{PI, TAU};

use serde_json::{Value, json};

use super::figure::Figure;
use super::presentation::{Presentation, Provenance};
use super::table::{Table, or_blank};
use super::te_lines::{arcsec, degrees, direction_name, micrometres};
use super::{encoder_te_plot, encoder_te_table};
use crate::base::error::Error;
use crate::encoder::flank::{FlankEvaluation, OrderEstimate};
use crate::encoder::gear_train::GearTrain;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::logs::attribution::{AttributedOrder, Attribution, DeclaredSource};
use crate::plan::logs::encoder_analysis::EncoderResult;
use crate::recording::raw::Repair;

/// The transmission error of a record of two encoders.
pub struct EncoderReport {
    /// Above the plot.
    pub title: String,
    /// Repairs of the data.
    pub repairs: Vec<Repair>,
    /// The evaluation.
    pub result: EncoderResult,
    /// The teeth between the encoders.
    pub teeth: GearTrain,
    /// Every order is shown, not the largest only.
    pub all: bool,
}

impl Presentation for EncoderReport {
    fn provenance(&self) -> Provenance<'_> {
        Provenance::of_log(&self.result.trace, &self.repairs, &self.result.diagnostics)
    }

    fn body(&self) -> Result<Value, Error> {
        Ok(body(&self.result, &self.teeth))
    }

    fn text(&self) -> String {
        encoder_te_table::record(&self.result, self.all)
    }

    fn table(&self) -> Table<'_> {
        let found = &self.result;
        let play = found.measured.backlash.as_ref();
        let play = play.and_then(|p| p.variation.as_ref()).map(|c| &c.signal);
        let mut table = Table::new("direction|angle_deg|te_arcsec|long_wave_arcsec")
            .columns_if(found.radius.is_some(), "te_um")
            .columns_if(play.is_some(), "play_arcsec");
        let arc = |x: Option<&f64>| or_blank(x, |x| format!("{:.6}", arcsec(*x)));
        for flank in &found.measured.flanks {
            for (i, e) in flank.signal.values.iter().enumerate() {
                let angle = flank.signal.angle(i).to_degrees();
                let mut cells = vec![
                    direction_name(flank).to_string(),
                    format!("{angle:.9}"),
                    arc(Some(e)),
                    arc(flank.composite.long_wave.get(i)),
                ];
                cells.extend(micrometres(found, *e).map(|um| format!("{um:.6}")));
                cells.extend(play.map(|play| {
                    let at = usize::try_from(flank.signal.first + i as i64 - play.first).ok();
                    arc(at.and_then(|at| play.values.get(at)))
                }));
                table.row(cells);
            }
        }
        table
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let figure = encoder_te_plot::record(&self.result, &self.title);
        Ok(vec![Figure::first(figure)])
    }
}

/// The document of a transmission error from encoders, without what its provenance adds.
pub fn body(found: &EncoderResult, teeth: &GearTrain) -> Value {
    let measured = &found.measured;
    let mut flanks: Vec<Value> = measured.flanks.iter().map(|f| flank(f, found)).collect();
    for (flank, all) in flanks.iter_mut().zip(&found.attribution) {
        flank["attribution"] = attribution(all);
    }
    let mut document = flanks.first().cloned().unwrap_or(json!({}));
    let more = json!({
        "method_text": found.method_text,
        "teeth": teeth.pairs().iter().map(|p| [p.0, p.1]).collect::<Vec<_>>(),
        "hunting_turns": teeth.hunting_turns().to_string(),
        "ratio": {
            "declared": measured.tooth_ratio.to_string(),
            "declared_value": measured.tooth_ratio.to_f64(),
            "measured": measured.ratio.value,
            "known_to_relative": measured.ratio.relative_uncertainty,
        },
        "rows_per_tooth": measured.rows_per_tooth,
        "highest_order": measured.band,
        "mesh_multiples": measured.multiples,
        "interpolation_error_relative": measured.order_error,
        "quantisation_arcsec": arcsec(measured.quantisation),
        "flanks": flanks,
        "play": measured.backlash.as_ref().map(|p| json!({
            "mean_arcsec": arcsec(p.mean),
            "mean_um": micrometres(found, p.mean),
            "least_arcsec": p.variation.as_ref().map(|c| arcsec(c.range.0)),
            "most_arcsec": p.variation.as_ref().map(|c| arcsec(c.range.1)),
            "std_arcsec": p.variation.as_ref().map(|c| arcsec(c.deviation)),
            "angle_deg": p.variation.as_ref().map(|c| (0..c.signal.values.len()).map(|i| c.signal.angle(i).to_degrees()).collect::<Vec<_>>()),
            "arcsec": p.variation.as_ref().map(|c| c.signal.values.iter().map(|x| arcsec(*x)).collect::<Vec<_>>()),
        })),
        "speed": measured.speed.as_ref().map(|s| {
            let (mean, least, most) = s.range();
            let rpm = |w: f64| w * 30.0 / PI;
            json!({ "mean_rpm": rpm(mean), "least_rpm": rpm(least), "most_rpm": rpm(most) })
        }),
        "eccentricity": found.separated.iter().map(|p| json!({
            "shaft": p.shaft,
            "encoder_arcsec": arcsec(p.encoder),
            "gear_arcsec": arcsec(p.gear),
            "std_arcsec": arcsec(p.deviation),
        })).collect::<Vec<_>>(),
        "index": measured.index.iter().flatten().map(|i| json!({
            "shaft": i.shaft,
            "passages": i.passages,
            "missing": i.missing,
            "extra": i.extra,
            "counts_apart": i.counts_between_passages,
            "at_deg": 360.0 * i.mark_angle,
            "scatter_deg": 360.0 * i.scatter,
        })).collect::<Vec<_>>(),
        "runs": measured.runs.iter().map(|r| json!({
            "direction": if r.forward { "forward" } else { "backward" },
            "first_row": r.rows.start + 1,
            "last_row": r.rows.end,
            "input_turns": r.travel() / TAU,
        })).collect::<Vec<_>>(),
        "limits": found.limits,
        "repaired": measured.removed_steps.iter().map(|j| json!({
            "row": j.row + 1, "counts": j.counts, "encoder": j.encoder, "step_arcsec": arcsec(j.step),
            "or": j.alternative.map(|(counts, encoder)| json!({ "counts": counts, "encoder": encoder })),
        })).collect::<Vec<_>>(),
    });
    if let (Some(document), Value::Object(more)) = (document.as_object_mut(), more) {
        document.extend(more);
    }
    document
}

fn flank(flank: &FlankEvaluation, found: &EncoderResult) -> Value {
    let composite = &flank.composite;
    let um = |angle: f64| micrometres(found, angle);
    let all = |list: &[f64]| list.iter().map(|x| arcsec(*x)).collect::<Vec<_>>();
    json!({
        "direction": direction_name(flank),
        "turns": flank.turns,
        "whole_turns": composite.turns,
        "whole_hunting_cycles": composite.closed,
        "total_arcsec": arcsec(composite.total),
        "total_um": um(composite.total),
        "one_turn_arcsec": arcsec(composite.per_rev.sliding),
        "tooth_to_tooth_arcsec": arcsec(composite.per_pitch.sliding),
        "tooth_to_tooth_um": um(composite.per_pitch.sliding),
        "tooth_to_tooth_fixed_arcsec": arcsec(composite.per_pitch.fixed),
        "each_tooth_arcsec": all(&composite.per_pitch.each),
        "long_wave_arcsec": arcsec(composite.long_wave_component.0),
        "long_wave_by_pitch_mean_arcsec": arcsec(composite.long_wave_component.1),
        "short_wave_arcsec": arcsec(composite.short_wave_component.0.sliding),
        "short_wave_by_pitch_mean_arcsec": arcsec(composite.short_wave_component.1.sliding),
        "noise_rms_arcsec": arcsec(flank.noise),
        "of_orders": {
            "total_arcsec": arcsec(flank.fitted.total),
            "one_turn_arcsec": arcsec(flank.fitted.per_rev),
            "tooth_to_tooth_arcsec": arcsec(flank.fitted.per_pitch),
            "std_arcsec": arcsec(flank.fitted.deviation),
            "bound_arcsec": arcsec(flank.fitted.bound),
            "tooth_to_tooth_bound_arcsec": arcsec(flank.fitted.bound_by_pitch),
        },
        "attribution": null,
        "mean_turns": flank.shaft_averages.iter().map(|m| json!({
            "shaft": m.shaft,
            "turns": m.revolutions,
            "range_arcsec": arcsec(peak_to_peak(&m.values)),
            "standard_error_arcsec": arcsec(m.standard_error),
            "te_arcsec": all(&m.values),
        })).collect::<Vec<_>>(),
        "orders": flank.lines.iter().map(|l| line(l, found)).collect::<Vec<_>>(),
        "unexplained": flank.unexplained.iter().map(|u| json!({
            "order_value": u.order,
            "order_known_to": u.order_uncertainty,
            "amplitude_arcsec": arcsec(u.amplitude),
            "nearest": u.nearest,
        })).collect::<Vec<_>>(),
    })
}

/// Attribution of the lines. A declared error in µm, of couplings in mrad.
fn attribution(all: &Attribution) -> Value {
    let source = |s: &DeclaredSource| {
        json!({
            "source": s.name,
            "unit": s.display_unit(),
            "declared": s.to_display_unit(s.declared),
            "arrives_arcsec": arcsec(s.output_amplitude),
            "identified": s.identified.map(|f| s.to_display_unit(f.0)),
            "identified_interval": s.identified.map(|f| [s.to_display_unit(f.1.0), s.to_display_unit(f.1.1)]),
        })
    };
    let row = |r: &AttributedOrder| {
        json!({
            "order": r.order.to_string(),
            "order_value": r.order.to_f64(),
            "amplitude_arcsec": arcsec(r.amplitude),
            "even_input_arcsec": arcsec(r.amplitude_uniform_input),
            "sources": r.sources.iter().map(source).collect::<Vec<_>>(),
        })
    };
    json!({
        "sources": all.sources,
        "rank": all.rank,
        "orders": all.rows.iter().map(row).collect::<Vec<_>>(),
        "beyond": all.unresolved,
    })
}

fn line(line: &OrderEstimate, found: &EncoderResult) -> Value {
    json!({
        "order": line.order.fraction.to_string(),
        "order_value": line.order.value,
        "sources": line.order.names,
        "amplitude_arcsec": arcsec(line.amplitude),
        "amplitude_um": micrometres(found, line.amplitude),
        "std_arcsec": arcsec(line.deviation),
        "interval_arcsec": line.interval.map(|(low, high)| [arcsec(low), arcsec(high)]),
        "phase_deg": degrees(line.phase),
        "phase_from_mark_deg": line.mark_phase.map(|m| degrees(m.0)),
        "mark": line.mark_phase.map(|m| m.1),
        "significant": line.significant,
        "shared": line.is_shared(),
        "not_resolved_from": line.unresolved().iter().map(|n| json!({ "what": n.name, "turns_needed": n.turns })).collect::<Vec<_>>(),
    })
}
