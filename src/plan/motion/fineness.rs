//! Whether the samples of an output follow it: how far it goes from one to the next, by its own slope, beside how far it swings.

use std::f64::consts::TAU;

use super::scene::MotionScene;
use crate::motion::problem::Problem;
use crate::motion::regime::Regime;

/// Instants looked at, at most: a slope costs an evaluation of the equations.
const LOOKS: usize = 256;

/// Share of the time between two samples over which a slope is taken.
const NEAR: f64 = 1e-4;

/// Share of an output's size below which its swings are nothing beside it.
const SLIGHT: f64 = 1e-3;

/// Fewest samples that tell anything of a course.
const COURSE: usize = 4;

/// Looks at outputs while a motion runs.
///
/// For a sine the mean size of the slope over the mean deviation is its ω, wherever the samples lie in its period; so what is as fast
/// as the samples, or much faster, is seen, where a look at the samples alone would take it for something slow. A jump counts by
/// its height and no more. What repeats exactly from sample to sample with no slope there cannot be seen.
pub struct Fineness {
    /// Between two samples, s.
    spacing: f64,
    /// Of so many samples one is looked at.
    every: usize,
    seen: usize,
    /// Of each output, where looked at.
    values: Vec<Vec<f64>>,
    /// Of each output, the sum of the sizes of its slopes.
    slopes: Vec<f64>,
}

/// An output whose samples do not follow it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coarse {
    /// Its number.
    pub output: usize,
    /// Samples in a period of a sine that goes so far.
    pub per_period: f64,
}

impl Fineness {
    /// For the samples of a scene.
    pub fn new(scene: &MotionScene) -> Fineness {
        let outputs = scene.outputs.list.len();
        Fineness {
            spacing: scene.until / scene.samples as f64,
            every: scene.samples / LOOKS + 1,
            seen: 0,
            values: vec![Vec::new(); outputs],
            slopes: vec![0.0; outputs],
        }
    }

    /// Takes the next sample: the state, how everything stands and the outputs there.
    pub fn look(
        &mut self,
        scene: &MotionScene,
        (t, y): (f64, &[f64]),
        regime: Option<&Regime>,
        now: &[f64],
    ) {
        let train = &scene.moving.train;
        let due = self.seen.is_multiple_of(self.every);
        self.seen += 1;
        // Where nodes have no inertia the equations give no slope of every state.
        if !due || train.has_light() || scene.samples < COURSE {
            return;
        }
        // Nothing switches between the two instants of a slope.
        let stood = train.stands(regime, t, y);
        let regime = Some(&*stood);
        let near = NEAR * self.spacing;
        let mut slope = vec![0.0; train.len()];
        train.slope_in(regime, t, y, &mut slope);
        let beyond: Vec<f64> = y.iter().zip(&slope).map(|(y, s)| y + near * s).collect();
        let then = scene.outputs.at(train, regime, t + near, &beyond);
        for (at, (now, then)) in now.iter().zip(&then).enumerate() {
            if then.is_finite() {
                self.values[at].push(*now);
                self.slopes[at] += (then - now).abs() / near;
            }
        }
    }

    /// The output that is followed least, where so few samples as `fewest` lie in a period.
    pub fn coarsest(&self, fewest: f64) -> Option<Coarse> {
        let of = |(output, values): (usize, &Vec<f64>)| {
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let off = values.iter().map(|x| (x - mean).abs()).sum::<f64>() / count;
            let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let turned = self.spacing * self.slopes[output] / count / off.max(SLIGHT * size);
            Coarse {
                output,
                per_period: TAU / turned,
            }
        };
        let all = self.values.iter().enumerate().map(of);
        all.filter(|coarse| coarse.per_period < fewest)
            .min_by(|a, b| a.per_period.total_cmp(&b.per_period))
    }
}
