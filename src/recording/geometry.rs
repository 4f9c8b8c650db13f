//! Geometry of a test: points, lines between them, point and direction of each channel.

/// Points, lines and channels of a test.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Geometry {
    /// Points, each with a name of its own.
    pub points: Vec<GeometryPoint>,
    /// Lines through points, by their indices; two or more each.
    pub lines: Vec<Vec<usize>>,
    /// Channels with a direction.
    pub channels: Vec<ChannelPlace>,
}

/// A point of the structure.
#[derive(Debug, Clone, PartialEq)]
pub struct GeometryPoint {
    /// Name.
    pub name: String,
    /// Cartesian coordinates, m.
    pub at: [f64; 3],
}

/// Point and direction of a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelPlace {
    /// Name of the channel.
    pub channel: String,
    /// Index of its point; `None` where each file of a roving test is a point.
    pub point: Option<usize>,
    /// Unit vector of its positive direction.
    pub direction: [f64; 3],
}

impl Geometry {
    /// Whether no point is stated.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Index of the point of a name.
    pub fn point(&self, name: &str) -> Option<usize> {
        self.points.iter().position(|p| p.name == name)
    }

    /// Point and direction of a channel; `None` where one of them is not stated.
    pub fn place(&self, channel: &str) -> Option<(usize, [f64; 3])> {
        let mut own = self.channels.iter().filter(|c| c.channel == channel);
        own.find_map(|c| Some((c.point?, c.direction)))
    }

    /// Places the channels of a roving test: `name` of a pair (channel, name) is `point` or `channel@point`, and the channel states the
    /// direction.
    pub fn place_roving<'a>(&mut self, channels: impl IntoIterator<Item = &'a (String, String)>) {
        for (channel, name) in channels {
            let point = name
                .rsplit_once('@')
                .map_or(name.as_str(), |(_, point)| point);
            let Some(point) = self.point(point) else {
                continue;
            };
            let mut own = self.channels.iter().filter(|c| c.channel == *channel);
            let Some(direction) = own.find(|c| c.point.is_none()).map(|c| c.direction) else {
                continue;
            };
            self.channels.push(ChannelPlace {
                channel: name.clone(),
                point: Some(point),
                direction,
            });
        }
    }
}
