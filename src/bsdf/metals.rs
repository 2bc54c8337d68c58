//! Measured metals.
//!
//! The spectra of n and k are those that refractiveindex.info collects (its database is in the public domain):
//! Johnson and Christy 1972 (copper, gold, silver) and 1974 (chromium, cobalt, iron, nickel, palladium, titanium),
//! Rakić 1995 (aluminium) and Rakić et al. 1998, Brendel–Bormann model (platinum, tungsten), Querry 1985 (brass,
//! Cu70Zn30), Inagaki et al. 1981 (mercury).
//!
//! A renderer of three channels needs three pairs that *look* the same: the reflected spectrum under D65, weighed
//! with the CIE 1931 observer (in the fit of Wyman et al. 2013) and brought to linear Rec.709 where a perfect mirror is
//! (1, 1, 1), gives each channel its reflectance at normal incidence and its average over the hemisphere; η and k
//! of the channel are those that have both. Up to 82° they stay within 0.012 of the spectrum's colour. Gold's red
//! lies outside of Rec.709 and is cut at 0.99.

/// (name, η, k) per channel, linear Rec.709.
pub const METALS: &[(&str, [f32; 3], [f32; 3])] = &[
    ("aluminium", [1.496, 0.990, 0.607], [7.649, 6.562, 5.355]),
    ("brass", [0.540, 0.524, 1.133], [4.563, 2.680, 1.817]),
    ("chromium", [3.239, 3.122, 2.286], [3.286, 3.337, 3.117]),
    ("cobalt", [2.259, 2.040, 1.716], [4.222, 3.800, 3.240]),
    ("copper", [0.269, 1.042, 1.300], [3.633, 2.631, 2.365]),
    ("gold", [0.035, 0.489, 1.483], [3.500, 2.240, 1.781]),
    ("iron", [2.921, 2.921, 2.546], [3.074, 2.939, 2.750]),
    ("mercury", [2.048, 1.526, 1.027], [5.309, 4.616, 3.799]),
    ("nickel", [2.045, 1.908, 1.733], [4.199, 3.578, 2.898]),
    ("palladium", [1.801, 1.626, 1.398], [4.362, 3.819, 3.215]),
    ("platinum", [2.365, 2.073, 1.830], [4.251, 3.685, 3.094]),
    ("silver", [0.057, 0.055, 0.043], [4.492, 3.567, 2.592]),
    ("titanium", [2.757, 2.510, 2.243], [3.841, 3.400, 3.016]),
    ("tungsten", [3.667, 3.493, 3.298], [2.812, 2.753, 2.595]),
];
