//! What was shown: the readings of all sensors at every moment of a demonstration, and what the expert did there.

/// A demonstration, everything sensed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// Numbers that each sensor delivers.
    pub widths: Vec<usize>,
    /// Readings scaled to [0, 1], moment by moment, sensor by sensor.
    pub readings: Vec<f64>,
    /// What the expert did at each moment.
    pub actions: Vec<usize>,
    /// Episode of each moment: what is held out are whole episodes, whose moments resemble each other.
    pub episodes: Vec<usize>,
}

impl Shown {
    /// Nothing yet, of sensors with these widths.
    #[must_use]
    pub fn of(widths: Vec<usize>) -> Self {
        Self { widths, ..Self::default() }
    }

    /// One more moment: the readings of all sensors one after the other, the expert's action, the episode.
    ///
    /// # Panics
    /// If there are more or fewer readings than the sensors deliver.
    pub fn add(&mut self, readings: &[f64], action: usize, episode: usize) {
        assert_eq!(readings.len(), self.dims(), "one reading per feature");
        self.readings.extend_from_slice(readings);
        self.actions.push(action);
        self.episodes.push(episode);
    }

    /// Number of sensors.
    #[must_use]
    pub fn sensors(&self) -> usize {
        self.widths.len()
    }

    /// Number of moments.
    #[must_use]
    pub fn len(&self) -> usize {
        self.actions.len()
    }

    /// Whether nothing was shown.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.actions.is_empty()
    }

    /// Readings of one moment.
    #[must_use]
    pub fn dims(&self) -> usize {
        self.widths.iter().sum()
    }

    /// Readings of moment `at`, all sensors.
    #[must_use]
    pub fn moment(&self, at: usize) -> &[f64] {
        &self.readings[at * self.dims()..(at + 1) * self.dims()]
    }

    /// Where the readings of `sensor` stand in a moment.
    #[must_use]
    pub fn place(&self, sensor: usize) -> std::ops::Range<usize> {
        let start = self.widths[..sensor].iter().sum();
        start..start + self.widths[sensor]
    }

    /// One more than the largest action.
    #[must_use]
    pub fn action_count(&self) -> usize {
        self.actions.iter().max().map_or(0, |most| most + 1)
    }
}
