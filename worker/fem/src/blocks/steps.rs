//! Step limits of single elements, and what is wrong with an element at which a run stops.

use super::{Block, Blocks, cycles_of};
use crate::nodes::Nodes;
use crumple_math::row::xyz;
use crumple_proto::ids::ElemId;

impl Blocks {
    /// Returns the smallest step limit of own elements at the present coordinates and its
    /// element, the lowest id among equals. The limit is the stable step, for slow elements
    /// divided by the number of cycles of an outer step. An element whose step is not a number
    /// comes first, with a step of 0 [time].
    pub fn smallest_step(&self, nodes: &Nodes) -> Option<(f64, ElemId)> {
        let limits = self.blocks.iter().filter(|b| !b.idle).flat_map(|b| {
            let own = (0..b.count).filter(|i| !self.elements[b.first + i].record.failed);
            own.map(|i| (self.step_of(b, i, nodes), self.elements[b.first + i].record.id))
        });
        limits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }

    /// Returns the step limit of element `i` of a block, 0 if it is not a number [time].
    fn step_of(&self, b: &Block, i: usize, nodes: &Nodes) -> f64 {
        let e = &self.elements[b.first + i];
        if b.element.can_fail() && b.element.failed(b.state(i)) {
            return f64::INFINITY;
        }
        let dt = b.element.stable_dt_now(b.state(i), &e.nodes.map(|n| xyz(&nodes.x[n as usize])));
        let dt =
            if dt.is_nan() { 0.0 } else { dt * (e.record.mass_factor * e.record.share).sqrt() };
        dt.min(e.record.stable_dt) / cycles_of(&e.record, self.subcycles)
    }

    /// Returns the smallest step limit of own elements [time]. `of_kernels` is that of a pass
    /// over them: kernels include neither mass scaling nor elements that share the masses of
    /// nodes.
    pub fn stable_step(&self, nodes: &Nodes, of_kernels: f64) -> f64 {
        if self.mass_scaled {
            return self.smallest_step(nodes).map_or(f64::INFINITY, |s| s.0);
        }
        let weak = self.weak.iter().map(|&[block, i]| self.step_of(&self.blocks[block], i, nodes));
        weak.fold(of_kernels, f64::min)
    }

    /// Returns what is wrong with an own element and what to try; `None` for elements of other
    /// workers.
    pub fn diagnose(
        &self,
        nodes: &Nodes,
        id: ElemId,
        safety: f64,
        first_dt: f64,
    ) -> Option<String> {
        let i = self.elements.iter().position(|e| e.record.id == id)?;
        let (b, e) = (
            self.blocks.iter().find(|b| (b.first..b.first + b.count).contains(&i))?,
            &self.elements[i],
        );
        let dt = b
            .element
            .stable_dt_now(b.state(i - b.first), &e.nodes.map(|n| xyz(&nodes.x[n as usize])));
        let dt = dt * (e.record.mass_factor * e.record.share).sqrt()
            / cycles_of(&e.record, self.subcycles);
        let what = if dt.is_nan() {
            "is inverted, or its coordinates are not finite".to_string()
        } else if safety * dt < 0.5 * first_dt {
            format!("needs a step of {:.3e}; the first step was {first_dt:.3e}", safety * dt)
        } else {
            "was strained by more than 0.5 in one step, or its forces are not finite".to_string()
        };
        let try_this = if safety > 1.0 {
            format!("time.safety = {safety} is above the stability limit: use 0.9 or less")
        } else {
            "inspect the last fields around it; try a finer mesh, a lower time.safety or another \
             hourglass form"
                .into()
        };
        Some(format!("element {id} {what}; {try_this}"))
    }
}
