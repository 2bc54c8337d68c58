//! The developed picture: named channels of f32 or u32. This is all that `output` sees.

/// A channel's samples, row by row from the top left pixel.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Linear values.
    F32(Vec<f32>),
    /// Ids; never filtered.
    U32(Vec<u32>),
}

/// One named channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// `R`, `G`, `B` for the picture itself; `layer.X` for the rest, e.g. `depth.Z`.
    pub name: String,
    /// `width·height` samples.
    pub data: Data,
}

/// A picture with named channels, and what made it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Where the top left pixel lies in the full picture (`--crop`).
    pub offset: [u32; 2],
    /// The full picture's size.
    pub full_size: [u32; 2],
    /// The channels, `R`, `G`, `B` first.
    pub channels: Vec<Channel>,
    /// Settings, seed, version, backend, samples done: canonical JSON with sorted keys.
    pub settings: String,
}

impl Image {
    /// A picture with only `R`, `G`, `B`, row by row from the top.
    pub fn from_rgb(width: u32, height: u32, pixels: &[[f32; 3]], settings: String) -> Image {
        let channel = |name: &str, i: usize| Channel {
            name: name.to_string(),
            data: Data::F32(pixels.iter().map(|p| p[i]).collect()),
        };
        Image {
            width,
            height,
            offset: [0, 0],
            full_size: [width, height],
            channels: vec![channel("R", 0), channel("G", 1), channel("B", 2)],
            settings,
        }
    }

    /// The f32 channel of that name.
    pub fn f32_channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.name == name).and_then(|c| match &c.data {
            Data::F32(values) => Some(values.as_slice()),
            Data::U32(_) => None,
        })
    }

    /// The colour of pixel `i` (row by row); black where the picture has no colour channels.
    pub fn rgb(&self, i: usize) -> [f32; 3] {
        ["R", "G", "B"].map(|name| self.f32_channel(name).and_then(|c| c.get(i).copied()).unwrap_or(0.0))
    }

    /// All colours, row by row.
    pub fn rgb_pixels(&self) -> Vec<[f32; 3]> {
        let n = self.width as usize * self.height as usize;
        let channels = ["R", "G", "B"].map(|name| self.f32_channel(name));
        let at = |c: usize, i: usize| channels[c].and_then(|c| c.get(i).copied()).unwrap_or(0.0);
        (0..n).map(|i| [at(0, i), at(1, i), at(2, i)]).collect()
    }
}
