//! Every text that a person reads, in one place for translation. Frames count from 1 here, as people count.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::document::Door;
use crate::running::Step;
use crate::timing::{Pace, Way};

pub(crate) const PROGRAM: &str = "Marey Studio";
pub(crate) const SUBTITLE: &str = "Turn a clip of something alive into animation that you can use.";

// Starting.
pub(crate) const DOOR_CREATURE: &str = "A creature from a clip";
pub(crate) const DOOR_CREATURE_TEXT: &str =
    "Film an animal from the side, draw a stroke along each limb, and get a textured 3D creature that moves.";
pub(crate) const CHOOSE_CLIP: &str = "Choose a clip…";
pub(crate) const OR_DROP: &str = "or drop one on the window";
pub(crate) const DOOR_CHARACTER: &str = "A character that moves";
pub(crate) const DOOR_CHARACTER_TEXT: &str =
    "Take a picture of a drawing, see its skeleton, and let it move as anything that was filmed.";
pub(crate) const CHOOSE_PICTURE: &str = "Choose a picture…";
pub(crate) const DOOR_DRAWING: &str = "A drawing that lives";
pub(crate) const DOOR_DRAWING_TEXT: &str = "Mark points on a clip, and the lines of a vector drawing move as they do.";
pub(crate) const CHOOSE_DRAWING_CLIP: &str = "Choose a clip for it…";
pub(crate) const SAMPLES: &str = "TRY IT";
pub(crate) const FOX: &str = "A fox that walks";
pub(crate) const FOX_TEXT: &str = "Drawn on three frames already. Opens, is made into a creature, and plays.";
pub(crate) const OPEN_FOX: &str = "Open the sample: a fox that walks";
pub(crate) const CHILD: &str = "A girl who waves";
pub(crate) const CHILD_TEXT: &str = "A child's drawing with a skeleton. Opens, waves, and steps on the spot.";
pub(crate) const OPEN_CHILD: &str = "Open the sample: a girl who waves";
pub(crate) const HORSE: &str = "A horse that gallops";
pub(crate) const HORSE_TEXT: &str = "Sixteen lines that take the gallop of a clip. Opens, and plays.";
pub(crate) const OPEN_HORSE: &str = "Open the sample: a horse that gallops";
pub(crate) const UNSAVED: &str = "NOT SAVED YET";
pub(crate) const UNSAVED_ONE: &str = "Unnamed session";
pub(crate) const RECENT: &str = "RECENT";
pub(crate) const NO_RECENT: &str = "Sessions that you save are listed here.";
pub(crate) const OPEN_SESSION: &str = "Open a session…";
pub(crate) const DISCARD: &str = "Discard";
pub(crate) const KEEP: &str = "Keep";
pub(crate) const FORGET: &str = "Take off the list";
pub(crate) const DROP: &str = "Let go to open it";

// Files.
pub(crate) const PICK_CLIP: &str = "Choose a clip";
pub(crate) const PICK_SESSION: &str = "Open a session";
pub(crate) const SAVE_AS: &str = "Save the session";
pub(crate) const PICK_PICTURE: &str = "Choose a picture of a drawing";
pub(crate) const PICTURES_OF: &str = "Pictures";
pub(crate) const PICK_DRAWING: &str = "Choose a vector drawing";
pub(crate) const DRAWINGS: &str = "SVG drawings";
pub(crate) const PICK_MOTION_CLIP: &str = "Choose a clip to take the motion from";
pub(crate) const PICK_MOTION: &str = "Choose a motion";
pub(crate) const MOTIONS: &str = "Motions, BVH files and sessions";
pub(crate) const EXPORT_TO: &str = "Export to";
pub(crate) const CLIPS: &str = "Clips";
pub(crate) const SESSIONS: &str = "Marey sessions";
pub(crate) const NO_DIALOGS: &str = "The desktop has no dialog for files here: it needs a portal or zenity. Type the path, ~ for your folder; or drop the \
     file on the window.";
pub(crate) const PATH: &str = "Path";
pub(crate) const CHOOSE: &str = "Choose";
pub(crate) const NO_HOME: &str = "there is no folder for data of programs; set HOME or XDG_DATA_HOME";
pub(crate) const OPENING_BROKE: &str =
    "Opening it failed in a way that should not be. What was saved is untouched; please report it.";
pub(crate) const DRAWING_BROKE: &str = "Drawing the preview failed in a way that should not be; please report it.";
pub(crate) const NO_CLIP: &str =
    "The clip of this session is not there. Put it back where it was, and open the session again.";

// Steps of undo.
pub(crate) const EDIT_OPEN: &str = "opening the clip";
pub(crate) const EDIT_ADD_LIMB: &str = "new limb";
pub(crate) const EDIT_DRAW: &str = "stroke";
pub(crate) const EDIT_FACING: &str = "facing";
pub(crate) const EDIT_ORDER: &str = "which limb is in front";
pub(crate) const EDIT_REMOVE_STROKE: &str = "removing a stroke";
pub(crate) const EDIT_REMOVE_LIMB: &str = "removing a limb";
pub(crate) const EDIT_NAME_LIMB: &str = "limb's name and side";
pub(crate) const EDIT_TAKE_STROKES: &str = "strokes from a file";
pub(crate) const EDIT_MAKE: &str = "making the creature";
pub(crate) const EDIT_PAINT: &str = "painting";
pub(crate) const EDIT_REMOVE_PAINT: &str = "removing paint";
pub(crate) const EDIT_METHOD: &str = "how it is made";
/// Behind the label of the step that was followed.
pub(crate) const EDIT_FOLLOWED: &str = ", followed";
pub(crate) const EDIT_MOVE_KEY: &str = "moving a key frame";

pub(crate) const EDIT_MARK: &str = "new point";
pub(crate) const EDIT_ON_DRAWING: &str = "which points hold the drawing";
pub(crate) const EDIT_PROPOSE: &str = "finding points";
pub(crate) const EDIT_MOVE_POINT: &str = "moving a point";
pub(crate) const EDIT_UNMARK: &str = "removing a mark";
pub(crate) const EDIT_REMOVE_POINT: &str = "removing a point";
pub(crate) const EDIT_TAKE_POINTS: &str = "points from a file";
pub(crate) const EDIT_DRAWING: &str = "another drawing";
pub(crate) const EDIT_HANDLE: &str = "moving a point on the drawing";
pub(crate) const EDIT_HOW: &str = "how it moves";
pub(crate) const EDIT_REBIND: &str = "laying it anew";
pub(crate) const EDIT_STIFFNESS: &str = "stiffness";
pub(crate) const EDIT_PICTURE: &str = "another picture";
pub(crate) const EDIT_JOINT: &str = "moving a joint";
pub(crate) const EDIT_SKELETON: &str = "proposing the skeleton";
pub(crate) const EDIT_MOTION: &str = "another motion";
pub(crate) const EDIT_CLIP: &str = "a clip to take the motion from";
pub(crate) const EDIT_FOLLOWS: &str = "what a joint follows";

// The bar.
pub(crate) const TO_START: &str = "To the start";
pub(crate) const UNDO: &str = "Undo";
pub(crate) const REDO: &str = "Redo";
pub(crate) const SAVED: &str = "Saved";
pub(crate) const MODIFIED: &str = "Not saved";
pub(crate) const NOT_SAVED: &str = "No name yet";
pub(crate) const SAVED_HINT: &str =
    "Every stroke is kept on the disk at once, and comes back after a crash. Saving puts it into your file.";
pub(crate) const LIGHT: &str = "Light or dark";
pub(crate) const SHORTCUTS: &str = "Keys";
pub(crate) const MAKE: &str = "Make the creature";
pub(crate) const UPDATE: &str = "Update the creature";
pub(crate) const MAKE_HINT: &str = "Tracks the limbs, cuts the creature out, and builds it";
pub(crate) const MAKING: &str = "Making the creature";
pub(crate) const TRACKING: &str = "Following your correction";
pub(crate) const EXPORTING: &str = "Exporting";
pub(crate) const EXPORT: &str = "Export…";
pub(crate) const EXPORT_HINT: &str = "Writes it for Blender, game engines, the web";
pub(crate) const DRAW_FIRST: &str =
    "There is nothing to follow yet. Draw a stroke along each limb of the animal, from the body outward.";
pub(crate) const MAKE_FIRST: &str = "There is no creature to export yet. Make it first.";
pub(crate) const BUSY: &str = "Something is being made. Wait for its end, or cancel it.";
pub(crate) const CANCELLED: &str = "Cancelled. Nothing was changed.";
pub(crate) const STOPPING: &str = "Stopping";

// The canvas.
pub(crate) const DRAW_HINT: &str =
    "Draw a stroke along the body, then one along each leg, the neck and the tail, from the body outward.";
pub(crate) const STROKES: &str = "Strokes";
pub(crate) const TRACKS: &str = "Tracked";
pub(crate) const PATHS: &str = "Paths";
pub(crate) const MASK: &str = "Mask";
pub(crate) const OVERLAPS: &str = "Overlaps";
pub(crate) const TOOL_LIMBS: &str = "Draw limbs";
pub(crate) const TOOL_CREATURE: &str = "Paint what is the creature";
pub(crate) const TOOL_BESIDE: &str = "Paint what is not the creature";
pub(crate) const BRUSH: &str = "Radius of the brush in pixels";
pub(crate) const REMOVE_PAINT: &str = "Clear this frame";
pub(crate) const PAINT_HINT: &str =
    "Paint over what was cut out wrong, and update the creature: green is the creature, red is not.";
pub(crate) const FIT: &str = "Fit";

// A drawing that lives.
pub(crate) const MARK_HINT: &str =
    "Click on what moves: head, back, tail, then each joint and foot. Or let Next find some.";
pub(crate) const MARK_FIRST: &str = "Mark at least three points on the clip, and they will be laid on the drawing.";
pub(crate) const NEXT_MARK: &str = "Next: find points";
pub(crate) const NO_POINTS: &str = "Each click on the clip becomes a point here. Next finds some by itself.";
pub(crate) const MORE_POINTS: &str = "Click for more. Where a point strays, drag it back on that frame.";
pub(crate) const POINT_SELECTED: &str = "Drag it on the clip or on the drawing. Delete takes its mark off this frame.";
pub(crate) const ON_DRAWING: &str = "It holds the drawing";
pub(crate) const ON_DRAWING_HINT: &str = "Off where the drawing has no such place, as a far leg that was not drawn.";
pub(crate) const DRAWING: &str = "DRAWING";
pub(crate) const CHOOSE_DRAWING: &str = "From an SVG file…";
pub(crate) const CHOOSE_A_DRAWING: &str = "Choose a drawing…";
pub(crate) const OURS: &str = "One of ours";
pub(crate) const NO_DRAWING: &str = "The drawing that is to move: an SVG of lines. Drop it here, or choose one.";
pub(crate) const SHEET_NAME: &str = "The drawing";
pub(crate) const NUMBERS: &str = "Numbers";
pub(crate) const FIT_DRAWING: &str = "Fit the drawing";
pub(crate) const LAID: &str = "HOW IT IS LAID";
pub(crate) const LAID_HINT: &str = "Equal numbers belong together. Drag one on the drawing where it is wrong.";
pub(crate) const MIRRORED: &str = "Faces the other way";
pub(crate) const MIRRORED_HINT: &str = "The drawing looks to the other side than what was filmed";
pub(crate) const ON_SPOT: &str = "Stays on the spot";
pub(crate) const ON_SPOT_HINT: &str = "It moves its limbs, but does not go across the picture";
pub(crate) const LIKE_THIS: &str = "Lay it on this frame";
pub(crate) const LIKE_THIS_HINT: &str = "Choose the frame in which what was filmed stands most like the drawing";
pub(crate) const STIFFNESS: &str = "LINES";
pub(crate) const STIFFNESS_NAME: &str = "How stiff the lines are";
pub(crate) const STIFFNESS_HINT: &str = "How much lines keep their shape while they move";
pub(crate) const SOFT: &str = "soft";
pub(crate) const STIFF: &str = "stiff";
pub(crate) const MOVE_FIRST: &str = "Nothing moves yet. Go through the steps on the left first.";

pub(crate) const ALL_FOLLOWED: &str = "Every point is followed.";

// A character that moves.
pub(crate) const PICTURE: &str = "PICTURE";
pub(crate) const OTHER_PICTURE: &str = "Another picture…";
pub(crate) const SKELETON: &str = "Skeleton";
pub(crate) const SKELETON_HINT: &str = "Proposed. Drag a joint where it is wrong.";
pub(crate) const SKELETON_OWN: &str = "Drag a joint to move it.";
pub(crate) const PROPOSE_SKELETON: &str = "Propose it anew";
pub(crate) const PROPOSE_SKELETON_HINT: &str = "Drops this skeleton for one that is found in the drawing";
pub(crate) const MOTION: &str = "MOTION";
pub(crate) const OUR_MOTIONS: &str = "One of our motions";
pub(crate) const CHOOSE_MOTION: &str = "Choose a motion…";
pub(crate) const CHOOSE_MOTION_HINT: &str = "A motion.json, a BVH file, or a session in which something was tracked";
pub(crate) const CAPTURE: &str = "From a clip…";
pub(crate) const CAPTURE_HINT: &str = "Mark the joints on a clip of somebody who moves, and they are followed";
pub(crate) const ON_CLIP: &str = "Clip";
pub(crate) const MARK_JOINTS: &str =
    "Click on the clip where each joint is: the one that is to be next is bright on the drawing.";
pub(crate) const NEXT_MARK_JOINTS: &str = "Next: mark joints";
pub(crate) const MARKS_OF_ANOTHER: &str = "The joints of another drawing were marked on the clip. This one takes the same motion. Select a joint to say what it follows.";
pub(crate) const SELECT_JOINT: &str = "Select a joint on the drawing, and click where it is on the clip.";
pub(crate) const CARRIED: &str = "HOW IT FOLLOWS";
pub(crate) const ABSOLUTE: &str = "Limbs point as the motion's do";
pub(crate) const ABSOLUTE_HINT: &str = "Else each turns as much as the motion's, from where it was drawn";
pub(crate) const STRETCH: &str = "Limbs may stretch";
pub(crate) const STRETCH_HINT: &str = "How much longer or shorter a limb can become";
pub(crate) const FOLLOWS_NOTHING: &str = "nothing";
pub(crate) const FIGURE_NAME: &str = "The character as it was drawn";
pub(crate) const MOVING_NAME: &str = "The character in motion";
pub(crate) const NO_MOTION: &str = "Choose a motion on the left, and it plays here.";
pub(crate) const NO_MOTION_THERE: &str = "Nothing was tracked in that session. Make its creature first.";
pub(crate) const SEEING: &str = "One moment…";

// Limbs.
pub(crate) const NEW_LIMB: &str = "New limb";
pub(crate) const NO_LIMBS: &str = "Each stroke on the clip becomes a limb here.";
pub(crate) const DRAWS_NEW: &str = "The next stroke makes a new limb. Select one to draw it again on another frame.";
pub(crate) const LIMB_NAME: &str = "name";
pub(crate) const SIDE: &str = "Side";
pub(crate) const SIDE_HINT: &str =
    "Of a pair of legs, say which is near to the camera and which is far: they are told apart by it.";
pub(crate) const SIDE_UNKNOWN: &str = "not said";
pub(crate) const SIDE_NEAR: &str = "near";
pub(crate) const SIDE_FAR: &str = "far";
pub(crate) const SIDE_MID: &str = "middle";
pub(crate) const END: &str = "Its end is";
pub(crate) const FACING_FLAT: &str = "level";
pub(crate) const FACING_FLAT_HINT: &str = "As far from the camera as its start";
pub(crate) const FACING_TOWARD: &str = "nearer";
pub(crate) const FACING_TOWARD_HINT: &str = "It points toward the camera";
pub(crate) const FACING_AWAY: &str = "farther";
pub(crate) const FACING_AWAY_HINT: &str = "It points away from the camera";
pub(crate) const CROSSES: &str = "On this frame it is";
pub(crate) const ORDER_HINT: &str =
    "It holds here, and fades toward the key frames around. Update the creature to see it.";
pub(crate) const ORDER_UNSAID: &str = "As the machine has it";
pub(crate) const MAKE_TO_ORDER: &str =
    "Make the creature first. Then it can be said which of two limbs is in front, where they cross.";
pub(crate) const SELECT_TO_ORDER: &str = "Select the limb that is to be in front, or click where it crosses another.";
pub(crate) const REMOVE_STROKE: &str = "Remove its stroke here";

// Time.
pub(crate) const TIMELINE: &str = "Frame";
pub(crate) const PLAY: &str = "Play";
pub(crate) const PAUSE: &str = "Pause";
pub(crate) const LOOP: &str = "Loop";
pub(crate) const FIRST_FRAME: &str = "First frame";
pub(crate) const PREVIOUS_FRAME: &str = "Previous frame";
pub(crate) const NEXT_FRAME: &str = "Next frame";
pub(crate) const LAST_FRAME: &str = "Last frame";
pub(crate) const NEXT_CORRECTION: &str = "Next to correct";
pub(crate) const NEXT_CORRECTION_HINT: &str = "Goes to the frame and the limb that a new stroke would help most";

pub(crate) const ONION: &str = "Onion skin";
pub(crate) const ONION_SETTINGS: &str = "Onion skin: how much";
pub(crate) const ONION_BEFORE: &str = "Poses before";
pub(crate) const ONION_AFTER: &str = "Poses after";
pub(crate) const ONION_EVERY: &str = "Frames between";
pub(crate) const TIMING_HINT: &str = "How long pictures stand, and how time passes";
pub(crate) const TIMING_PICTURES: &str = "Pictures";
pub(crate) const TIMING_PACE: &str = "Pace";
pub(crate) const TIMING_WAY: &str = "Way";
pub(crate) const TIMING_SPEED: &str = "Speed";
pub(crate) const TIMING_ABOUT: &str = "Drawn animation is often on twos. It is exported as it plays.";
pub(crate) const EDIT_TIMING: &str = "Timing";

// The creature.
pub(crate) const VIEW3D_NAME: &str = "The creature in 3D";
pub(crate) const STYLE: &str = "What is shown";
pub(crate) const STYLE_TEXTURED: &str = "Textured";
pub(crate) const STYLE_SHADED: &str = "Shaded";
pub(crate) const STYLE_WIREFRAME: &str = "Wireframe";
pub(crate) const STYLE_RADIUS: &str = "Thickness";
pub(crate) const STYLE_BONES: &str = "Bones";
pub(crate) const STYLE_DEPTH: &str = "Depth";
pub(crate) const STYLE_NORMALS: &str = "Normals";
pub(crate) const AS_FILMED: &str = "As filmed";
pub(crate) const ORBIT_HINT: &str = "Drag to turn";

// Exporting.
pub(crate) const GLB: &str = "glTF (.glb)";
pub(crate) const GLB_USE: &str = "Mesh, bones, animation and texture in one file, for Blender and game engines";
pub(crate) const FOLDER: &str = "Everything, in a folder";
pub(crate) const FOLDER_USE: &str = "The .glb, masks, motion.json, previews and a report";
pub(crate) const GIF: &str = "GIF";
pub(crate) const GIF_USE: &str = "Plays everywhere; hard edges, 256 colours";
pub(crate) const APNG: &str = "Animated PNG";
pub(crate) const APNG_USE: &str = "See-through and lossless, in every browser";
pub(crate) const WEBP: &str = "Animated WebP";
pub(crate) const WEBP_USE: &str = "See-through and smaller, in every browser";
pub(crate) const MP4: &str = "Film (.mp4)";
pub(crate) const MP4_USE: &str = "For film editors; it cannot be see-through";
pub(crate) const PICTURES: &str = "PNG pictures, in a folder";
pub(crate) const PICTURES_USE: &str = "One for each frame, for compositing";
pub(crate) const SVG: &str = "Animated SVG";
pub(crate) const SVG_USE: &str = "Lines that move on any web page, sharp at any size";
pub(crate) const LOTTIE: &str = "Lottie (.json)";
pub(crate) const LOTTIE_USE: &str = "For apps and web pages, and for After Effects";
pub(crate) const SPINE: &str = "Spine, in a folder";
pub(crate) const SPINE_USE: &str = "Skeleton, atlas and picture, for games";
pub(crate) const DRAGONBONES: &str = "DragonBones, in a folder";
pub(crate) const DRAGONBONES_USE: &str = "Skeleton, atlas and picture, for games";
pub(crate) const SHEET: &str = "Sprite sheet";
pub(crate) const SHEET_USE: &str = "All frames on one PNG, with their places in JSON";
pub(crate) const PREVIEW_NAME: &str = "Preview";
pub(crate) const FROM: &str = "From";
pub(crate) const FROM_FILMED: &str = "where it was filmed";
pub(crate) const FROM_SHOWN: &str = "where you look now";
pub(crate) const FROM_AROUND: &str = "all around, once";
pub(crate) const SIZE: &str = "Size";
pub(crate) const BEHIND: &str = "Behind";
pub(crate) const NOTHING: &str = "nothing";
pub(crate) const COLOR: &str = "a colour";
pub(crate) const COLOR_NAME: &str = "The colour behind";
pub(crate) const TO_FILE: &str = "File";
pub(crate) const TO_FOLDER: &str = "Folder";
pub(crate) const BROWSE: &str = "Browse…";
pub(crate) const REPLACES: &str = "What is there under this name will be replaced.";
pub(crate) const EXPORT_NOW: &str = "Export";
pub(crate) const CANCEL: &str = "Cancel";
pub(crate) const CLOSE: &str = "Close";
pub(crate) const CLOSE_NOTICE: &str = "Close this message";

// Plugins.
pub(crate) const PLUGINS: &str = "Plugins";
pub(crate) const NO_PLUGINS: &str = "None yet. What is built in needs none.";
pub(crate) const NOT_LOADED: &str = "Not loaded";
pub(crate) const TRY_AGAIN: &str = "Try again";
pub(crate) const LOOK_AGAIN: &str = "Look again";
pub(crate) const PLUGIN_ON: &str = "On";
pub(crate) const SETTINGS: &str = "Settings";
pub(crate) const KIND_TRACKER: &str = "follows limbs";
pub(crate) const KIND_SEGMENTER: &str = "cuts out";
pub(crate) const BENT_BY: &str = "Bent by";
pub(crate) const NEEDLES: &str = "needles, which keep the area";
pub(crate) const NEEDLES_ABOUT: &str = "Short straight pieces across each limb: what was drawn keeps its width";
pub(crate) const RIGID: &str = "as rigid as possible";
pub(crate) const RIGID_ABOUT: &str = "The whole drawing resists being bent and stretched";
pub(crate) const MESH: &str = "Mesh";
pub(crate) const NEEDLES_SHOWN: &str = "Needles";
pub(crate) const FIT_MOVING: &str = "Fit what moves";
pub(crate) const KIND_DEFORMER: &str = "deforms";
pub(crate) const METHODS: &str = "How the creature is made";
pub(crate) const FOLLOWED_BY: &str = "Limbs are followed by";
pub(crate) const CUT_BY: &str = "It is cut out by";
pub(crate) const BUILT_IN: &str = "what is built in";
pub(crate) const BUILT_IN_ABOUT: &str = "The best of what was measured, on most clips";
pub(crate) const ALL_PLUGINS: &str = "All plugins…";
pub(crate) const PLUGIN_GONE: &str =
    "This plugin is not there, or is switched off. Choose another, or look at all plugins.";

// Keys.
pub(crate) const GROUP_SESSION: &str = "SESSION";
pub(crate) const GROUP_DRAWING: &str = "DRAWING";
pub(crate) const GROUP_TIME: &str = "TIME";
pub(crate) const GROUP_LOOKING: &str = "LOOKING";
pub(crate) const GROUP_MORE: &str = "MORE";
pub(crate) const DO_OPEN_CLIP: &str = "Choose a clip";
pub(crate) const DO_OPEN: &str = "Open a session";
pub(crate) const DO_SAVE: &str = "Save";
pub(crate) const DO_SAVE_AS: &str = "Save under another name";
pub(crate) const DO_UNDO: &str = "Undo";
pub(crate) const DO_REDO: &str = "Redo";
pub(crate) const DO_CANCEL: &str = "Drop the stroke, or the selection";
pub(crate) const DO_START: &str = "To the start";
pub(crate) const DO_NEW_LIMB: &str = "Draw a new limb";
pub(crate) const DO_NEXT_LIMB: &str = "Select the next limb";
pub(crate) const DO_REMOVE_STROKE: &str = "Remove the limb's stroke here";
pub(crate) const DO_ORDER: &str = "In front of what it crosses, or behind";
pub(crate) const DO_FACING: &str = "Its end: level, nearer, farther";
pub(crate) const DO_TOOL_LIMBS: &str = "Draw limbs";
pub(crate) const DO_TOOL_CREATURE: &str = "Paint the creature";
pub(crate) const DO_TOOL_BESIDE: &str = "Paint what is beside it";
pub(crate) const DO_NARROWER: &str = "A narrower brush";
pub(crate) const DO_WIDER: &str = "A wider brush";
pub(crate) const DO_NEXT_CORRECTION: &str = "Go to what to correct next";
pub(crate) const DO_MAKE: &str = "Make the creature";
pub(crate) const DO_PLAY: &str = "Play, pause";
pub(crate) const DO_PREVIOUS_FRAME: &str = "Previous frame";
pub(crate) const DO_NEXT_FRAME: &str = "Next frame";
pub(crate) const DO_PREVIOUS_KEY: &str = "Previous key frame";
pub(crate) const DO_NEXT_KEY: &str = "Next key frame";
pub(crate) const DO_FIRST_FRAME: &str = "First frame";
pub(crate) const DO_LAST_FRAME: &str = "Last frame";
pub(crate) const DO_LOOP: &str = "Loop, or play once";
pub(crate) const DO_ONION: &str = "Onion skin";
pub(crate) const DO_FIT: &str = "Fit the clip";
pub(crate) const DO_ZOOM_IN: &str = "Nearer";
pub(crate) const DO_ZOOM_OUT: &str = "Farther";
pub(crate) const DO_STROKES: &str = "Show strokes";
pub(crate) const DO_TRACKS: &str = "Show tracked limbs";
pub(crate) const DO_PATHS: &str = "Show paths";
pub(crate) const DO_MASK: &str = "Show the mask, or the mesh";
pub(crate) const DO_OVERLAPS: &str = "Show which limb is in front, or needles";
pub(crate) const DO_CLIP: &str = "The clip of a character's motion, or its drawing";
pub(crate) const DO_NEXT_STYLE: &str = "Next style of the creature";
pub(crate) const DO_AS_FILMED: &str = "Creature as it was filmed";
pub(crate) const DO_EXPORT: &str = "Export";
pub(crate) const DO_EXPORT_AGAIN: &str = "Export again, as last time";
pub(crate) const DO_LIGHT: &str = "Light or dark";
pub(crate) const DO_PLUGINS: &str = "Plugins";
pub(crate) const DO_METHODS: &str = "How the creature is made";
pub(crate) const DO_HELP: &str = "This list";
pub(crate) const PRESS_KEYS: &str = "press keys…";
pub(crate) const NO_KEY: &str = "none";
pub(crate) const KEYS_HINT: &str = "Click on keys to choose others.";
pub(crate) const TAKE_KEY_AWAY: &str = "No key";
pub(crate) const LEAVE_KEY: &str = "Leave it";
pub(crate) const USE_KEY: &str = "Use them here";
pub(crate) const RESET_KEYS: &str = "All keys as they were";
pub(crate) const KEY_MOVES: &str = "This key moves through every window, and stays what it is. Press others.";
pub(crate) const KEY_EDITS: &str = "These keys copy and paste text, and stay what they are. Press others.";
pub(crate) const MOUSE_HELP: &str = "Wheel: nearer, farther. Space or the middle button, held: move the clip. Click on a limb: select it. Right click on its end: level, nearer, farther. Click on a mark where two limbs cross: the other one is in front; a right click on a limb asks. Diamonds on the timeline can be dragged.";

pub(crate) fn no_window(why: &str) -> String {
    format!(
        "cannot open a window: {why}; Marey Studio needs a display, and Vulkan, Metal, Direct3D 12 or OpenGL to draw"
    )
}

pub(crate) fn no_folder(folder: &Path, why: &std::io::Error) -> String {
    format!("{}: cannot be written to: {why}; make room, or give yourself the right to", folder.display())
}

pub(crate) fn no_memory(why: &std::io::Error) -> String {
    format!("What you chose cannot be remembered: {why}. Everything else works.")
}

pub(crate) fn not_there(path: &Path) -> String {
    format!("{}: there is nothing under this name", path.display())
}

pub(crate) fn no_such_folder(path: &Path) -> String {
    format!("{}: there is no such folder", path.display())
}

pub(crate) fn name_a_file(path: &Path) -> String {
    format!("{}: that is a folder; add a name", path.display())
}

/// How long ago, for a person.
pub(crate) fn ago(seconds: u64) -> String {
    let of = |count: u64, one: &str| if count == 1 { format!("1 {one} ago") } else { format!("{count} {one}s ago") };
    match seconds {
        0..=59 => "just now".into(),
        60..=3599 => of(seconds / 60, "minute"),
        3600..=86_399 => of(seconds / 3600, "hour"),
        _ => of(seconds / 86_400, "day"),
    }
}

pub(crate) fn open_named(title: &str) -> String {
    format!("Open {title}")
}

pub(crate) fn with_name(what: &str, title: &str) -> String {
    format!("{what}: {title}")
}

pub(crate) fn discard_sure(title: &str) -> String {
    format!("Discard {title} for good?")
}

pub(crate) fn opening(name: &str) -> String {
    format!("Opening {name}…")
}

pub(crate) fn recovered(gestures: u64) -> String {
    match gestures {
        1 => "The last step, which was not saved, is here again.".into(),
        _ => format!("The last {gestures} steps, which were not saved, are here again."),
    }
}

pub(crate) fn with_key(text: &str, key: &str) -> String {
    format!("{text} ({key})")
}

pub(crate) fn with_what(text: &str, what: Option<&str>) -> String {
    what.map_or_else(|| text.to_owned(), |what| format!("{text}: {what}"))
}

pub(crate) fn unreadable(path: &Path, why: &std::io::Error) -> String {
    format!("{}: cannot be read: {why}; choose another file", path.display())
}

/// What a step of the machine is called while it runs.
pub(crate) fn step(step: Step) -> &'static str {
    match step {
        Step::Points => "Following the points",
        Step::Propose => "Finding points",
        Step::Bind | Step::Rebind => "Laying it on the drawing",
        Step::Still => "Reading the drawing",
        Step::Character => "Finding the skeleton",
        Step::Move => "Moving it",
    }
}

pub(crate) fn points(count: usize) -> String {
    if count == 0 { "POINTS".into() } else { format!("POINTS · {count}") }
}

pub(crate) fn point_name(number: usize, name: &str) -> String {
    let number = (number + 1).to_string();
    if number == name { number } else { format!("{number}  {name}") }
}

pub(crate) fn times_marked(count: usize) -> String {
    if count == 1 { String::new() } else { format!("{count} marks") }
}

pub(crate) fn select_point(number: usize) -> String {
    format!("Select point {}", number + 1)
}

pub(crate) fn remove_point(number: usize) -> String {
    format!("Remove point {}", number + 1)
}

pub(crate) fn like_frame(frame: u64) -> String {
    format!("Laid on frame {}.", frame + 1)
}

pub(crate) fn skeleton(joints: usize) -> String {
    if joints == 0 { "SKELETON".into() } else { format!("SKELETON · {joints} joints") }
}

/// What to click on next; which are left out is up to a person.
pub(crate) fn mark_joint(number: usize, joint: Option<&str>, marked: usize, joints: usize) -> String {
    let number = number + 1;
    let which = joint.map_or_else(|| number.to_string(), |joint| format!("{number}, {joint},"));
    format!(
        "Click where joint {which} is: it is bright on the drawing. {marked} of {joints} are marked; leave out what cannot be seen."
    )
}

pub(crate) fn marked_joints(marked: usize, joints: usize) -> String {
    format!("{marked} of {joints} joints are marked on the clip. Where one strays, drag it back on that frame.")
}

pub(crate) fn follows(joint: &str) -> String {
    format!("{joint} follows")
}

pub(crate) fn times(value: f64) -> String {
    format!("{value:.1} ×")
}

pub(crate) fn canvas_name(frame: u64, frames: u64) -> String {
    format!("The clip, frame {} of {frames}", frame + 1)
}

pub(crate) fn limb_label(number: usize) -> String {
    format!("limb {number}")
}

pub(crate) fn limbs(count: usize) -> String {
    if count == 0 { "LIMBS".into() } else { format!("LIMBS · {count}") }
}

pub(crate) fn select_limb(label: &str) -> String {
    format!("Draw {label}")
}

pub(crate) fn name_of_limb(label: &str) -> String {
    format!("Name of {label}")
}

pub(crate) fn remove_limb(label: &str) -> String {
    format!("Remove {label}")
}

pub(crate) fn draws_again(label: &str) -> String {
    format!("The next stroke draws {label} on this frame, which becomes a key frame.")
}

pub(crate) fn in_front_of(label: &str) -> String {
    format!("In front of {label}")
}

pub(crate) fn behind(label: &str) -> String {
    format!("Behind {label}")
}

/// What a mark of two limbs says when the pointer is over it.
pub(crate) fn overlap(front: &str, behind: &str) -> String {
    format!("{front} is in front of {behind}. Click if it is behind.")
}

pub(crate) fn crosses_nothing(label: &str) -> String {
    format!("{label} crosses no other limb on this frame.")
}

pub(crate) fn timeline_name(frame: u64, frames: u64) -> String {
    format!("Timeline, frame {} of {frames}", frame + 1)
}

pub(crate) fn frame_name(frame: u64) -> String {
    format!("Frame {}", frame + 1)
}

pub(crate) fn key_frame(frame: u64) -> String {
    format!("Key frame {}", frame + 1)
}

pub(crate) fn key_frames(count: usize) -> String {
    match count {
        0 => "no key frames".into(),
        1 => "1 key frame".into(),
        _ => format!("{count} key frames"),
    }
}

pub(crate) fn place_in_time(frame: u64, frames: u64, seconds: f64) -> String {
    let of = frames.to_string();
    format!("{:>width$} / {of}   {seconds:>5.2} s", (frame + 1).min(frames), width = of.len())
}

/// For how many frames a picture is held, as animators say it.
pub(crate) fn held(frames: u32) -> String {
    match frames {
        1 => "on ones".into(),
        2 => "on twos".into(),
        3 => "on threes".into(),
        4 => "on fours".into(),
        _ => format!("for {frames} frames"),
    }
}

pub(crate) fn timing_name(words: &str) -> String {
    format!("Timing: {words}")
}

pub(crate) fn pace(pace: Pace) -> String {
    match pace {
        Pace::Even => "even",
        Pace::SlowStart => "slow start",
        Pace::SlowEnd => "slow end",
        Pace::SlowEnds => "slow ends",
    }
    .into()
}

pub(crate) fn way(way: Way) -> String {
    match way {
        Way::Forward => "forward",
        Way::Backward => "backward",
        Way::ThereAndBack => "there and back",
    }
    .into()
}

pub(crate) fn speed(percent: u32) -> String {
    match percent {
        25 => "a quarter".into(),
        50 => "half".into(),
        100 => "as it was".into(),
        200 => "double".into(),
        _ => format!("{percent} %"),
    }
}

pub(crate) fn frame_of(done: u64, count: u64) -> String {
    format!("frame {} of {count}", done.min(count))
}

pub(crate) fn percent(fraction: f64) -> String {
    format!("{:.0} %", 100.0 * fraction)
}

/// What the library is at. What it may call otherwise one day is said as it says it.
pub(crate) fn stage(stage: &str) -> &str {
    match stage {
        "" | "waiting" => "Waiting for its turn",
        "reading" => "Reading the clip",
        "tracking" => "Following the limbs",
        "segmenting" => "Cutting it out",
        "reconstructing" | "fitting" => "Building the body",
        "texturing" => "Painting the skin",
        "rendering" => "Drawing",
        "writing frames" => "Writing frames",
        other => other,
    }
}

pub(crate) fn progress(stage: &str, done: &str, left: Option<Duration>) -> String {
    match left.map(|left| left.as_secs_f64().ceil() as u64) {
        Some(left) => format!("{stage}, {done}, about {}:{:02} left", left / 60, left % 60),
        None => format!("{stage}, {done}"),
    }
}

pub(crate) fn exported(path: &Path) -> String {
    format!("Written: {}", path.display())
}

pub(crate) fn folder_name(title: &str) -> String {
    format!("{title} creature")
}

pub(crate) fn pictures_name(title: &str) -> String {
    format!("{title} frames")
}

pub(crate) fn sheet_name(title: &str) -> String {
    format!("{title} sheet")
}

pub(crate) fn bones_name(title: &str, spine: bool) -> String {
    if spine { format!("{title} spine") } else { format!("{title} dragonbones") }
}

pub(crate) fn export_title(door: Door) -> &'static str {
    match door {
        Door::Creature => "Export the creature",
        Door::Character => "Export the character",
        Door::Drawing => "Export the drawing",
    }
}

pub(crate) fn drawn_size_name(width: u32, height: u32, percent: u32) -> String {
    match percent {
        0 => format!("{width} × {height}, as drawn"),
        _ => format!("{width} × {height}"),
    }
}

pub(crate) fn size_name(width: u32, height: u32, of_clip: bool) -> String {
    if of_clip { format!("{width} × {height}, as the clip") } else { format!("{width} × {height}") }
}

pub(crate) fn model_about(vertices: u64, triangles: u64, bones: u32, frames: u64) -> String {
    format!("{vertices} vertices, {triangles} triangles, {bones} bones, {frames} frames.")
}

pub(crate) fn animation_about(frames: u64, fps: f64, film: bool, gif: bool) -> String {
    let about = format!("{frames} frames, {} a second.", (fps * 100.0).round() / 100.0);
    match (film, gif) {
        (true, _) => format!("{about} Films are not see-through."),
        (_, true) => format!("{about} Edges of a see-through GIF are hard."),
        _ => about,
    }
}

pub(crate) fn plugins_about(folder: &str) -> String {
    format!(
        "They follow limbs and cut creatures out by other means. New ones and new builds are found while you work, in {folder}."
    )
}

pub(crate) fn plugin_by(version: &str, vendor: &str) -> String {
    if vendor.is_empty() { version.to_owned() } else { format!("{version}, by {vendor}") }
}

pub(crate) fn plugin_file(file: &str, build: u64) -> String {
    if build > 1 { format!("{file}, build {build} since the start") } else { file.to_owned() }
}

pub(crate) fn plugin_rebuilt(name: &str) -> String {
    format!("{name} was built anew. The new build is used from now on.")
}

pub(crate) fn keys_of(what: &str, keys: &str) -> String {
    format!("Keys of {what}: {keys}")
}

pub(crate) fn keys_wanted(what: &str) -> String {
    format!("{what}: press the keys for it.")
}

pub(crate) fn keys_taken(keys: &str, by: &str) -> String {
    format!("{keys} are the keys of: {by}. Used here, it has none any more.")
}

pub(crate) fn session_file(title: &str) -> String {
    format!("{title}.marey")
}

pub(crate) fn with_session_ending(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".marey");
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_said_as_people_say_them() {
        assert_eq!(
            progress("tracking", "37 %", Some(Duration::from_millis(71_200))),
            "tracking, 37 %, about 1:12 left"
        );
        assert_eq!(progress("tracking", "frame 3 of 9", None), "tracking, frame 3 of 9");
        assert_eq!([ago(3), ago(60), ago(7300), ago(90_000)], ["just now", "1 minute ago", "2 hours ago", "1 day ago"]);
        assert_eq!(place_in_time(0, 60, 0.0), " 1 / 60    0.00 s");
        assert_eq!(place_in_time(0, 0, 0.0), "0 / 0    0.00 s");
    }
}
