//! A creature from tracked strokes and masks: generalized cylinders around the limbs, textured, on a bone hierarchy.
//! Source: Reinert, Ritschel, Seidel, "Animated 3D Creatures from Single-view Video by Skeletal Sketching", 2016.
