//! Hand of teeth.

/// Hand of the teeth of a gear; of a pair, that of its first gear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hand {
    /// Teeth turn clockwise going away from the viewer.
    #[default]
    Right,
    /// The mirror image.
    Left,
}

impl Hand {
    /// 1 for right, −1 for left.
    pub fn sign(self) -> f64 {
        match self {
            Hand::Right => 1.0,
            Hand::Left => -1.0,
        }
    }
}
