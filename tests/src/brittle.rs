//! A rod strikes a plate of cubes whose uppermost layer is brittle.

use crate::model_of;
use crumple::input::job::Model;
use crumple_verification::scene::{Cut, Scene};

/// Side of all cubes [mm].
pub const SIDE: f64 = 5.0;
/// Gap between rod and plate at the start [mm].
const GAP: f64 = 0.5;

/// Adds `count` cubes from `from`, layer by layer; `part` gives the part of a layer. Returns their
/// nodes.
fn add_cubes(
    scene: &mut Scene,
    count: [usize; 3],
    (from, cut): ([f64; 3], Cut),
    part: impl Fn(usize) -> u32,
) -> Vec<u32> {
    scene.cut(cut);
    let first = scene.count() + 1;
    let [a, b, c] = count;
    let id = |[i, j, k]: [usize; 3]| first + ((k * (b + 1) + j) * (a + 1) + i) as u32;
    for n in 0..(a + 1) * (b + 1) * (c + 1) {
        let step = [n % (a + 1), n / (a + 1) % (b + 1), n / ((a + 1) * (b + 1))];
        scene.node(std::array::from_fn(|axis| from[axis] + SIDE * step[axis] as f64));
    }
    for n in 0..a * b * c {
        let [i, j, k] = [n % a, n / a % b, n / (a * b)];
        let face = |k| [[i, j, k], [i + 1, j, k], [i + 1, j + 1, k], [i, j + 1, k]].map(id);
        let (below, above) = (face(k), face(k + 1));
        let corners = std::array::from_fn(|n| if n < 4 { below[n] } else { above[n - 4] });
        scene.solid(part(k), corners);
    }
    (first..=scene.count()).collect()
}

/// Returns a job in which a rod, one cube wide, strikes a plate whose uppermost layer is brittle
/// and whose other layers are not.
pub fn rod_on_plate(layers: usize) -> Model {
    rod_on_plate_with(layers, Cut::Whole, "")
}

/// Returns the job of [`rod_on_plate`] of other elements, with these lines in `[contact]`, or after
/// it.
pub fn rod_on_plate_with(layers: usize, cut: Cut, contact: &str) -> Model {
    let mut scene = Scene::default();
    let part = |layer| if layer + 1 == layers { 2 } else { 1 };
    let plate = add_cubes(&mut scene, [5, 5, layers], ([0.0; 3], cut), part);
    let top = layers as f64 * SIDE + GAP;
    let rod = add_cubes(&mut scene, [1, 1, 4], ([10.5, 9.5, top], cut), |_| 3);
    scene.set_named("floor", &plate[..36]);
    scene.set_named("rod", &rod);
    // Wedges average their volume strain above nu = 0.3.
    let poisson = if cut == Cut::Wedges { 0.45 } else { 0.3 };
    let text = format!(
        r#"
        title = "A rod through a brittle layer"
        units = "mm, ms, kg"
        end_time = 0.25
        {}
        [[material]]
        name = "tough"
        law = "elastic"
        density = 7.85e-6
        youngs_modulus = 200.0
        poisson = {poisson:?}
        [[material]]
        name = "brittle"
        law = "j2"
        density = 7.85e-6
        youngs_modulus = 200.0
        poisson = {poisson:?}
        yield_stress = 0.2
        failure_strain = 0.02
        [[material]]
        name = "heavy"
        law = "elastic"
        density = 2.4e-5
        youngs_modulus = 200.0
        poisson = {poisson:?}
        [[part]]
        id = 1
        material = "tough"
        [[part]]
        id = 2
        material = "brittle"
        [[part]]
        id = 3
        material = "heavy"
        [[fix]]
        nodes = "floor"
        dofs = ["x", "y", "z"]
        [[initial_velocity]]
        nodes = "rod"
        velocity = [0.0, 0.0, -100.0]
        [contact]
        {contact}
        "#,
        scene.mesh_text(),
    );
    model_of(&text, &[])
}

/// Returns the job of a block of `count` cubes along each edge in contact with itself, with these
/// lines in its material.
pub fn block(count: usize, material: &str) -> Model {
    let mut scene = Scene::default();
    add_cubes(&mut scene, [count; 3], ([0.0; 3], Cut::Whole), |_| 1);
    let text = format!(
        r#"
        title = "A block"
        units = "mm, ms, kg"
        end_time = 0.1
        {}
        [[material]]
        name = "steel"
        law = "j2"
        density = 7.85e-6
        youngs_modulus = 200.0
        poisson = 0.3
        yield_stress = 0.2
        {material}
        [[part]]
        id = 1
        material = "steel"
        [contact]
        "#,
        scene.mesh_text(),
    );
    model_of(&text, &[])
}
