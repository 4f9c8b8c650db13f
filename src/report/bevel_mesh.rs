//! Bevel pair under load: tables, JSON, values over the pitch.

use serde_json::{Value, json};

use super::bevel_stability;
use super::gear::ARCSEC;
use super::number_format::significant;
use super::table::{Table, decimal, or_dash};
use crate::gear::load::flank_mesh::MIN_ASPECT;
use crate::gear::load::flank_result::{FlankCycle, FlankLoad, FlankMeshResult, StripChange};
use crate::gear::load::tooth_plate::RootMoment;
use crate::numeric::statistics::{extremes, peak_to_peak};
use crate::plan::gear::bevel_mesh::{BevelMeshResult, MeshStudies};

/// Sign of the transmission error.
const TE_DIRECTION: &str =
    "positive where the gear leads; µm along the normal at the reference contact";

/// Stiffness along the normal of one about the gear's axis, N/m.
fn along_normal(result: &BevelMeshResult, stiffness: f64) -> f64 {
    stiffness / (result.lever * result.lever)
}

/// Least, mean and greatest of some values.
fn spread(values: &[f64]) -> [f64; 3] {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let (low, high) = extremes(values.iter().copied());
    [low, mean, high]
}

/// Transmission error and stiffness, then what the flanks bear: one row a torque.
pub fn text(result: &BevelMeshResult, studies: &MeshStudies) -> String {
    let mut text = format!(
        "{}te {TE_DIRECTION}; k in the same direction; the error of te is half its largest difference from half the stations\n\n{}local contact: {}; teeth: {}; left out: {}\n",
        stiffness_table(result, studies).text(),
        load_table(result).text(),
        local_contact(&result.mesh),
        result.body,
        result.left_out.join(", ")
    );
    if let Some(between) = studies.interpolation_error {
        text += &format!(
            "between the torques (cubics of the turn by its values and tangents; with every second torque omitted): te off by at most {:.2}″, {} µm, k secant by {} %, k tangent by {} % in the mean over the pitch\n",
            ARCSEC * between.deflection,
            significant(1e6 * result.lever * between.deflection),
            significant(100.0 * between.secant),
            significant(100.0 * between.tangent),
        );
    }
    if let Some(changes) = &studies.changes {
        text += &format!("\n{}", changes_table(result, changes).text());
    }
    if !studies.stability.is_empty() {
        text += &format!("\n{}", bevel_stability::table(&studies.stability).text());
    }
    text
}

/// Form of the local contact over all torques and positions.
fn local_contact(mesh: &FlankMeshResult) -> String {
    let loads = || mesh.cycles.iter().flat_map(|c| &c.positions);
    let all = loads().count();
    match loads().filter(|p| p.ellipses > 0).count() {
        0 => "half-space strips".into(),
        some => format!(
            "closed elliptic form below a/b {MIN_ASPECT} at {some} of {all} positions, half-space strips elsewhere"
        ),
    }
}

/// Torques over the positions at which more pairs of teeth begin to carry, and the changes of the set of strips.
fn changes_table(result: &BevelMeshResult, changes: &[Vec<StripChange>]) -> Table<'static> {
    let mut table = Table::numeric(
        "pairs that carry|from torque, least [N·m]|from torque, greatest [N·m]|positions|contact changes of strips, least|contact changes of strips, most",
    );
    let counts: Vec<f64> = changes.iter().map(|c| c.len() as f64).collect();
    let [least, _, most] = spread(&counts);
    for pairs in 2.. {
        let torques: Vec<f64> = changes
            .iter()
            .filter_map(|path| StripChange::onset_torque(path, pairs))
            .collect();
        if torques.is_empty() {
            break;
        }
        let [low, _, high] = spread(&torques);
        table.row([
            pairs.to_string(),
            significant(low),
            significant(high),
            format!("{} of {}", torques.len(), result.mesh.pinion_angles.len()),
            format!("{least}"),
            format!("{most}"),
        ]);
    }
    table
}

fn stiffness_table(result: &BevelMeshResult, studies: &MeshStudies) -> Table<'static> {
    let mut table = Table::numeric(
        "torque [N·m]|te peak to peak [arcsec]|te peak to peak [µm]|te mean [arcsec]|error of te [arcsec]|k secant mean [N/µm]|k tangent mean [N/µm]|k tangent least [N/µm]|k tangent most [N/µm]",
    );
    let mut row = |torque: String, te: &[f64], error: Option<f64>, stiffness: Option<[f64; 4]>| {
        let over = peak_to_peak(te);
        let mut cells = vec![
            torque,
            format!("{:.3}", ARCSEC * over),
            format!("{:.4}", 1e6 * result.lever * over),
            format!("{:.3}", ARCSEC * spread(te)[1] + 0.0),
            or_dash(error, |e| format!("{:.2}", ARCSEC * e)),
        ];
        cells.extend((0..4).map(|i| {
            or_dash(stiffness, |k| {
                significant(1e-6 * along_normal(result, k[i]))
            })
        }));
        table.row(cells);
    };
    row("0".into(), &result.mesh.unloaded_te, None, None);
    for (i, cycle) in result.mesh.cycles.iter().enumerate() {
        let [least, mean, most] = spread(&cycle.of(|p| p.tangent));
        let secant = spread(&cycle.of(|p| p.secant))[1];
        row(
            significant(cycle.torque),
            &cycle.of(|p| p.te),
            studies.te_errors.as_ref().map(|errors| errors[i]),
            Some([secant, mean, least, most]),
        );
    }
    table
}

fn load_table(result: &BevelMeshResult) -> Table<'static> {
    let mut table = Table::numeric(
        "torque [N·m]|pressure [N/mm²]|on edges [%]|greatest share of a pair [%]|pairs that carry|effective contact ratio|greatest shear [N/mm²]|depth [mm]|root moment of the pinion [N·m]|of the gear [N·m]",
    );
    for cycle in &result.mesh.cycles {
        let pressed = cycle.max_pressure_position();
        let shear = pressed.and_then(|p| p.shear);
        let edges = spread(&cycle.of(|p| p.edge_share))[2];
        let share = spread(&cycle.of(|p| p.shares.iter().map(|s| s.1).fold(0.0, f64::max)))[2];
        let [least, _, most] = spread(&cycle.of(|p| p.loaded_pairs() as f64));
        table.row([
            significant(cycle.torque),
            or_dash(pressed.and_then(|p| p.pressure), |p| {
                format!("{:.1}", 1e-6 * p)
            }),
            format!("{:.1}", 100.0 * edges),
            format!("{:.1}", 100.0 * share),
            match least == most {
                true => format!("{least}"),
                false => format!("{least} to {most}"),
            },
            format!("{:.3}", cycle.contact_ratio()),
            or_dash(shear, |s| format!("{:.1}", 1e-6 * s[1])),
            or_dash(shear, |s| format!("{:.4}", 1e3 * s[0])),
            or_dash(cycle.root_moment(0), |m| significant(m.total)),
            or_dash(cycle.root_moment(1), |m| significant(m.total)),
        ]);
    }
    table
}

/// The columns of `mesh`: lists over torques of lists over positions.
pub fn mesh_json(result: &BevelMeshResult, studies: &MeshStudies) -> Value {
    let (mesh, pairs) = (&result.mesh, result.mesh.pairs());
    let by = |value: &dyn Fn(&FlankLoad) -> f64| -> Vec<Vec<f64>> {
        mesh.cycles.iter().map(|c| c.of(value)).collect()
    };
    let each = |value: &dyn Fn(&FlankLoad) -> Value| -> Vec<Vec<Value>> {
        let of = |c: &FlankCycle| c.positions.iter().map(value).collect();
        mesh.cycles.iter().map(of).collect()
    };
    let micro = 1e6 * result.lever;
    let peaks = || mesh.cycles.iter().map(|c| peak_to_peak(&c.of(|p| p.te)));
    let of_root = |of: fn(&RootMoment) -> f64| {
        each(&|p| {
            let of_pair = |k: &i32| p.root_moments(*k).map(|moments| moments.each_ref().map(of));
            json!(pairs.iter().map(of_pair).collect::<Vec<_>>())
        })
    };
    let lengthwise = |cycle: &FlankCycle| {
        let line = cycle.lengthwise();
        let column = |k: usize| line.iter().map(|row| row[k]).collect::<Vec<f64>>();
        json!({ "face": column(0), "line_load_n_per_m": column(1) })
    };
    let changes = studies.changes.as_ref().map(|all| {
        let each = |path: &Vec<StripChange>| path.iter().map(change_json).collect::<Vec<_>>();
        all.iter().map(each).collect::<Vec<_>>()
    });
    json!({
        "method": "half-space strips",
        "local_contact": local_contact(mesh),
        "ellipses": each(&|p| json!(p.ellipses)),
        "root_moment_nm": of_root(|m| m.total),
        "root_line_moment_n": of_root(|m| m.greatest),
        "lengthwise": mesh.cycles.iter().map(lengthwise).collect::<Vec<_>>(),
        "changes": changes,
        "stability": bevel_stability::stability_json(&studies.stability),
        "body": result.body,
        "left_out": result.left_out,
        "te_direction": TE_DIRECTION,
        "te_error_arcsec": studies.te_errors.as_ref().map(|all| all.iter().map(|e| ARCSEC * e).collect::<Vec<_>>()),
        "between_torques": studies.interpolation_error.map(|between| json!({
            "te_arcsec": ARCSEC * between.deflection,
            "te_um": micro * between.deflection,
            "secant_relative": between.secant,
            "tangent_mean_relative": between.tangent,
        })),
        "lever_m": result.lever,
        "torques_nm": mesh.cycles.iter().map(|c| c.torque).collect::<Vec<_>>(),
        "pinion_angle_rad": mesh.pinion_angles,
        "pairs": pairs,
        "unloaded_te_arcsec": mesh.unloaded_te.iter().map(|e| ARCSEC * e).collect::<Vec<_>>(),
        "te_um": by(&|p| micro * p.te),
        "te_arcsec": by(&|p| ARCSEC * p.te),
        "stiffness_secant_n_per_m": by(&|p| along_normal(result, p.secant)),
        "stiffness_tangent_n_per_m": by(&|p| along_normal(result, p.tangent)),
        "shares": each(&|p| json!(pairs.iter().map(|k| p.share(*k)).collect::<Vec<_>>())),
        "edge_share": by(&|p| p.edge_share),
        "pressure_pa": each(&|p| json!(p.pressure)),
        "shear_pa": each(&|p| json!(p.shear.map(|s| s[1]))),
        "shear_depth_m": each(&|p| json!(p.shear.map(|s| s[0]))),
        "contact_ratio": mesh.cycles.iter().map(FlankCycle::contact_ratio).collect::<Vec<_>>(),
        "peak_to_peak_um": peaks().map(|e| micro * e).collect::<Vec<_>>(),
        "peak_to_peak_arcsec": peaks().map(|e| ARCSEC * e).collect::<Vec<_>>(),
        "unloaded_peak_to_peak_arcsec": ARCSEC * peak_to_peak(&mesh.unloaded_te),
    })
}

fn change_json(change: &StripChange) -> Value {
    json!({
        "torque_nm": change.torque,
        "pair": change.pair,
        "face": change.face,
        "begins": change.begins,
    })
}

/// One row a position: e and k at every torque.
pub fn position_table(result: &BevelMeshResult) -> Table<'_> {
    let mesh = &result.mesh;
    let arcsec = |values: &[f64]| {
        values
            .iter()
            .map(|e| ARCSEC * e + 0.0)
            .collect::<Vec<f64>>()
    };
    let mut table = Table::default()
        .numbers("pinion_angle", "rad", &mesh.pinion_angles[..], decimal)
        .numbers("te_unloaded", "arcsec", arcsec(&mesh.unloaded_te), decimal);
    for cycle in &mesh.cycles {
        let at = format!("{} N·m", decimal(cycle.torque));
        let stiffness = |value: fn(&FlankLoad) -> f64| cycle.of(|p| along_normal(result, value(p)));
        table = table
            .numbers(
                &format!("te at {at}"),
                "arcsec",
                arcsec(&cycle.of(|p| p.te)),
                decimal,
            )
            .numbers(
                &format!("secant stiffness at {at}"),
                "N/m",
                stiffness(|p| p.secant),
                decimal,
            )
            .numbers(
                &format!("tangent stiffness at {at}"),
                "N/m",
                stiffness(|p| p.tangent),
                decimal,
            );
    }
    table
}
