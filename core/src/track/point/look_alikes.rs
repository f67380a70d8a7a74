//! Points that look alike, told apart: where two of them were found in one place for some frames, each is offered the ways
//! around the other and a few quite other ways, and all choose together.

use glam::Vec2;
use rayon::prelude::*;

use super::candidates::Sought;
use super::footage::Footage;
use super::joint_choice::{Way, chosen};
use super::params::PointParams;
use super::stretch::{Key, Solved, Stretch, Trajectory};
use crate::error::Result;
use crate::job::Stage;

/// Frames together that are no mere passing.
const PASSING: usize = 2;

/// Ways that were found for stretches, kept for the next choice.
#[derive(Debug, Default)]
pub(super) struct LookAlikes {
    alternatives: Vec<(Stretch, Vec<Trajectory>)>,
    around: Vec<((Stretch, Stretch), Trajectory)>,
}

/// Frames in which two stretches' ways are in one place, both seen.
fn together(a: (&Stretch, &Trajectory), b: (&Stretch, &Trajectory), apart: f32) -> usize {
    let (from, to) = (a.0.from.max(b.0.from), a.0.to.min(b.0.to));
    let near = |f: &usize| {
        let (p, q) = (&a.1.places[f - a.0.from], &b.1.places[f - b.0.from]);
        p.seen && q.seen && p.at.distance(q.at) < apart
    };
    (from..=to).filter(near).count()
}

/// For every two of some marked places whether they look alike, row by row.
pub(super) fn alike(footage: &Footage, params: &PointParams, keys: &[Option<Key>]) -> Vec<bool> {
    let sought: Vec<Option<Sought>> = keys.iter().map(|key| key.map(|k| Sought::new(footage, k.frame, k.at))).collect();
    let pair = |a: &Option<Sought>, b: &Option<Sought>| match (a, b) {
        (Some(a), Some(b)) => a.unlike(b).min(b.unlike(a)) < params.alike,
        _ => false,
    };
    sought.iter().flat_map(|a| sought.iter().map(move |b| pair(a, b))).collect()
}

impl LookAlikes {
    /// For every point and its stretches, in order, the way that it went.
    pub(super) fn told_apart(
        &mut self,
        footage: &Footage,
        params: &PointParams,
        points: &[Vec<&Solved>],
        stage: Stage<'_>,
    ) -> Result<Vec<Vec<Trajectory>>> {
        let apart = params.together * footage.unit;
        let parts: Vec<(usize, &Solved)> =
            points.iter().enumerate().flat_map(|(i, list)| list.iter().map(move |s| (i, *s))).collect();
        let keys: Vec<Option<Key>> =
            points.iter().map(|list| list.iter().flat_map(|s| s.stretch.keys).flatten().next()).collect();
        let kin = alike(footage, params, &keys);
        let alike = |i: usize, j: usize| kin[i * keys.len() + j];
        let pairs: Vec<(usize, usize)> = (0..parts.len())
            .flat_map(|a| (a + 1..parts.len()).map(move |b| (a, b)))
            .filter(|&(a, b)| parts[a].0 != parts[b].0)
            .filter(|&(a, b)| {
                let (a, b) = (parts[a].1, parts[b].1);
                together((&a.stretch, &a.best), (&b.stretch, &b.best), apart) > PASSING
            })
            .filter(|&(a, b)| alike(parts[a].0, parts[b].0))
            .collect();
        let concerned: Vec<usize> = (0..parts.len()).filter(|i| pairs.iter().any(|(a, b)| a == i || b == i)).collect();
        self.alternatives.retain(|(s, _)| parts.iter().any(|p| p.1.stretch == *s));
        self.around.retain(|((s, t), _)| [s, t].iter().all(|s| parts.iter().any(|p| p.1.stretch == **s)));
        let fresh: Vec<usize> = concerned
            .iter()
            .copied()
            .filter(|&i| !self.alternatives.iter().any(|(s, _)| *s == parts[i].1.stretch))
            .collect();
        let found: Vec<(Stretch, Vec<Trajectory>)> = fresh
            .into_par_iter()
            .map(|i| {
                stage.at(0.3)?;
                Ok((parts[i].1.stretch, parts[i].1.alternatives(footage, params, stage.part(0.3, 0.3))?))
            })
            .collect::<Result<_>>()?;
        self.alternatives.extend(found);
        let fresh: Vec<(usize, usize)> = pairs
            .iter()
            .flat_map(|&(a, b)| [(a, b), (b, a)])
            .filter(|&(a, b)| {
                let key = (parts[a].1.stretch, parts[b].1.stretch);
                !self.around.iter().any(|(k, _)| *k == key)
            })
            .collect();
        let found: Vec<((Stretch, Stretch), Trajectory)> = fresh
            .into_par_iter()
            .map(|(a, b)| {
                stage.at(0.7)?;
                let (own, other) = (parts[a].1, parts[b].1);
                let mut others: Vec<Option<Vec2>> = vec![None; own.best.places.len()];
                for (f, p) in (other.stretch.from..).zip(other.best.seen()) {
                    if (own.stretch.from..=own.stretch.to).contains(&f) {
                        others[f - own.stretch.from] = p;
                    }
                }
                Ok(((own.stretch, other.stretch), own.around(footage, params, &others, stage.part(0.7, 0.7))?))
            })
            .collect::<Result<_>>()?;
        self.around.extend(found);
        let held: Vec<Vec<(usize, &Trajectory)>> = (0..parts.len())
            .map(|i| {
                let s = parts[i].1.stretch;
                let mut list = vec![(i, &parts[i].1.best)];
                if concerned.contains(&i) {
                    let other = |j: &usize| self.around.iter().find(|(k, _)| *k == (s, parts[*j].1.stretch));
                    let rivals = pairs.iter().filter_map(|&(a, b)| match i {
                        _ if a == i => Some(b),
                        _ if b == i => Some(a),
                        _ => None,
                    });
                    list.extend(rivals.filter_map(|j| other(&j)).map(|(_, t)| (i, t)));
                    let own = self.alternatives.iter().filter(|(k, _)| *k == s);
                    list.extend(own.flat_map(|(_, ways)| ways).map(|t| (i, t)));
                }
                list
            })
            .collect();
        let offered: Vec<Vec<Way<'_, (usize, &Trajectory)>>> =
            held.iter().map(|list| list.iter().map(|way| Way { cost: way.1.cost, way }).collect()).collect();
        let choice = chosen(&offered, params.shared, |a, b| {
            if parts[a.0].0 == parts[b.0].0 || !alike(parts[a.0].0, parts[b.0].0) {
                return 0.0;
            }
            together((&parts[a.0].1.stretch, a.1), (&parts[b.0].1.stretch, b.1), apart) as f32
        });
        let mut at = 0;
        Ok(points
            .iter()
            .map(|list| {
                let ways = (at..at + list.len()).map(|i| held[i][choice[i]].1.clone()).collect();
                at += list.len();
                ways
            })
            .collect())
    }
}
