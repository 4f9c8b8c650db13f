//! Chips of the members whose slots one head cuts from the solid in one setting.

use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::tooth_section::Side;
use crate::gear::cut::chips::{ChipCutter, ChipPlace, Chips, NoChips};
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::cut_file::CutFile;
use crate::scene::machine_settings::Process;

/// Length of the blades in depths of the tooth: the blank reaches no further above the root.
const BLADE_LENGTH: f64 = 1.5;

/// Chips of a member's slot.
#[derive(Debug, Clone)]
pub struct ChipResult {
    /// 0 for the pinion, 1 for the gear.
    pub member: usize,
    /// The chips.
    pub chips: Chips,
}

impl ChipResult {
    /// The place of the greatest area.
    pub fn greatest(&self) -> Option<&ChipPlace> {
        let by_area = |a: &&ChipPlace, b: &&ChipPlace| a.chip.area.total_cmp(&b.chip.area);
        self.chips.places.iter().max_by(by_area)
    }

    /// First and last turn of the cradle with a chip, rad.
    pub fn roll(&self) -> Option<[f64; 2]> {
        let mut places = self.chips.places.iter().filter(|p| p.chip.area > 0.0);
        let first = places.next()?.cradle;
        Some([first, places.next_back().map_or(first, |p| p.cradle)])
    }
}

/// The chips of a member, or why it has none.
///
/// # Errors
/// The reason.
pub fn chips(file: &CutFile, member: usize) -> Result<ChipResult, String> {
    let of = &file.bevel.members[member];
    let name = MEMBERS[member];
    let [Some(concave), Some(convex)] = &of.flanks else {
        return Err(format!("the {name} has settings for one flank only"));
    };
    if of.process != Process::Generated {
        return Err(format!(
            "the {name} is cut without a roll (formate), and its plunge feed is not described"
        ));
    }
    if concave.settings != convex.settings {
        return Err(format!(
            "the flanks of the {name} are cut in separate settings, in a slot that another cut has opened"
        ));
    }
    let hand = file.bevel.hand_of(member);
    let flank = BevelFlank::new(&concave.cutter, &concave.settings, hand, of.section);
    let blank = [Side::Tip, Side::Toe, Side::Heel].map(|side| of.section.side(side));
    let middle = flank.middle().ok_or(NoChips::NotInBlank);
    let found = middle.and_then(|[_, theta, turn]| {
        let cutter = ChipCutter::new(
            [&convex.cutter, &concave.cutter],
            concave.settings.motion(hand),
            (blank.to_vec(), BLADE_LENGTH * of.section.depth()),
            (file.study.feed(true), &file.study.offsets),
            theta,
        );
        cutter.chips(turn)
    });
    let chips = found.map_err(|why| match why {
        NoChips::CrossedBlades => {
            format!("the inside point radius of the {name}'s cutter is not below its outside one")
        }
        NoChips::NotInBlank => {
            format!("no blade reaches the blank of the {name} in the middle of its roll")
        }
        NoChips::NeverLeaves => {
            format!("the roll of the {name} does not move the blades out of the blank")
        }
        NoChips::TooManyPasses => {
            format!("the roll of the {name} has more than 1000 passes to one side of its middle")
        }
    })?;
    Ok(ChipResult { member, chips })
}

/// The stage of the plan.
pub fn decision(found: &[Result<ChipResult, String>]) -> StageDecision {
    let reasons: Vec<&str> = (found.iter())
        .filter_map(|f| f.as_ref().err().map(String::as_str))
        .collect();
    let passes = found.iter().flatten().map(|result| {
        let (name, passes) = (MEMBERS[result.member], result.chips.passes);
        format!("{name}: {passes} passes from the solid")
    });
    let runs: Vec<String> = passes.collect();
    match runs.is_empty() {
        true => StageDecision::LeftOut(reasons.join("; ")),
        false => StageDecision::Runs(format!(
            "{}; sharp straight blades on a true generator{}",
            runs.join("; "),
            reasons.iter().map(|r| format!("; {r}")).collect::<String>()
        )),
    }
}
