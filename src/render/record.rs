//! What made a picture, as JSON: the `drt` attribute, and what a checkpoint belongs to.

use crate::accel::Intersector;
use crate::film::PixelRule;
use crate::math::digest::Digest;
use crate::sampler::Splits;
use crate::scene::{BuildQuality, Compact, IntegratorKind, Scene, Settings};
use serde_json::{Value, json};

/// The `drt` attribute of a picture whose pixels have at least and at most `samples`.
pub fn attribute(s: &Settings, scene: &Scene, accel: &dyn Intersector, samples: (u32, u32)) -> String {
    let mut all = settings(s, scene, Some(accel));
    all["samples_done"] = json!({ "min": samples.0, "max": samples.1 });
    all["complete"] = json!(samples.0 == s.spp);
    all.to_string()
}

/// What a checkpoint belongs to: the settings, but for the number of samples, by name; all of them in a digest, so that
/// none is forgotten. Without `accel`: what is known before there is one.
pub fn identity(s: &Settings, scene: &Scene, accel: Option<&dyn Intersector>) -> Value {
    let mut named = settings(s, scene, accel);
    if let Some(render) = named["render"].as_object_mut() {
        render.remove("spp");
    }
    named["film"]["aov"] = s.aovs.iter().map(|aov| aov.name()).collect();
    let build = BuildQuality::Fixed(s.quality(scene.triangles()));
    let mut digest = Digest::new();
    digest.value(&Settings { spp: 0, split: None, build, compact: Compact::No, ..s.clone() });
    json!({ "drt": named, "settings": digest.hex() })
}

/// Everything that the picture's bits depend on, with sorted keys: no threads, paths, host, time or command line.
fn settings(s: &Settings, scene: &Scene, accel: Option<&dyn Intersector>) -> Value {
    let parameters = s.filter.parameters().into_iter().map(|(name, value)| (name.to_string(), json!(value)));
    let kind = ("type".to_string(), json!(s.filter.name()));
    let filter: serde_json::Map<String, serde_json::Value> = parameters.chain([kind]).collect();
    let mut all = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "film": {
            "size": s.size,
            "crop": s.crop,
            "filter": filter,
            "rule": rule_json(s.rule),
            "quantity": s.quantity.name(),
            "clamp": s.clamp,
        },
        "render": {
            "integrator": integrator_json(&s.integrator),
            "lights": s.lights.name(),
            "roulette": s.roulette,
            "split": match s.splits(scene) {
                Splits::Each(n) => json!(n),
                Splits::Later(n) => json!({ "preview": 1, "later": n }),
            },
            "spp": s.spp,
            "max_depth": s.max_depth,
            "seed": s.seed,
            "sampler": s.sampler.name(),
            "backend": s.backend.name(),
            "build": s.quality(scene.triangles()).name(),
        },
    });
    if let Some(accel) = accel {
        all["render"]["isa"] = json!(accel.isa());
        all["render"]["compact"] = json!(accel.compact());
    }
    all
}

fn integrator_json(kind: &IntegratorKind) -> serde_json::Value {
    match kind {
        IntegratorKind::Ao { distance } if distance.is_finite() => {
            json!({ "type": "ao", "distance": distance })
        }
        IntegratorKind::Distribution { rule, directions } => {
            let cells: Vec<[u32; 2]> = directions.cells().iter().map(|c| [c.theta, c.phi]).collect();
            let mut all = json!({ "type": kind.name(), "rule": rule.name(), "directions": cells });
            if let Some(per_cell) = rule.per_cell() {
                all["per_cell"] = json!(per_cell);
            }
            if let Some(measure) = rule.measure() {
                all["measure"] = json!(measure.name());
            }
            all
        }
        other => json!(other.name()),
    }
}

fn rule_json(rule: PixelRule) -> serde_json::Value {
    match rule.grid() {
        Some(grid) => json!({ "type": rule.name(), "grid": grid.cells, "per_cell": grid.per_cell }),
        None => json!(rule.name()),
    }
}
