//! The calls about characters.

use super::*;
use crate::character::{CharacterOptions, RetargetOptions, TakeFileOptions, TakeOptions};

destroy!(character_destroy, mry_character_destroy, mry_character);
destroy!(poser_destroy, mry_poser_destroy, mry_poser);
destroy!(poses_destroy, mry_poses_destroy, mry_poses);
destroy!(take_destroy, mry_take_destroy, mry_take);

pub(crate) fn start_character(handle: &Handle, options: &CharacterOptions<'_>) -> Result<mry_job> {
    let mut desc = sized!(mry_character_desc_init, mry_character_desc);
    (desc.picture, desc.mask) = (str(options.picture), str(options.mask));
    (desc.rig, desc.rig_json) = (str(options.rig), str(options.rig_json));
    (desc.vertices, desc.finer_at_joints) = (options.vertices, options.finer_at_joints);
    let mut job = mry_job::default();
    call!(mry_job_start_character(handle, &desc, &mut job))?;
    Ok(job)
}

pub(crate) fn take_character(handle: &Handle, job: mry_job) -> Result<mry_character> {
    taken(|out| call!(mry_job_take_character(handle, job, out)))
}

pub(crate) fn take_take(handle: &Handle, job: mry_job) -> Result<mry_take> {
    taken(|out| call!(mry_job_take_take(handle, job, out)))
}

pub(crate) fn job_report(handle: &Handle, job: mry_job) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_job_get_report(handle, job, text, capacity, size)))
}

pub(crate) fn character_info(handle: &Handle, character: mry_character) -> Result<mry_character_info> {
    let mut info = sized!(mry_character_info_init, mry_character_info);
    call!(mry_character_get_info(handle, character, &mut info))?;
    Ok(info)
}

pub(crate) fn character_joint(handle: &Handle, character: mry_character, joint: u32) -> Result<(String, mry_point)> {
    let mut at = mry_point::default();
    let name = sized_text(|name, capacity, size| {
        call!(mry_character_get_joint(handle, character, joint, name, capacity, size, &mut at))
    })?;
    Ok((name, at))
}

pub(crate) fn character_bone(handle: &Handle, character: mry_character, bone: u32) -> Result<[u32; 2]> {
    let mut ends = [0; 2];
    let [from, to] = &mut ends;
    call!(mry_character_get_bone(handle, character, bone, from, to))?;
    Ok(ends)
}

pub(crate) fn character_triangles(handle: &Handle, character: mry_character) -> Result<Vec<[u32; 3]>> {
    sized_list(|triangles: *mut [u32; 3], capacity, count| {
        call!(mry_character_read_triangles(handle, character, triangles.cast(), capacity, count))
    })
}

pub(crate) fn character_vertices(handle: &Handle, character: mry_character) -> Result<Vec<mry_point>> {
    sized_list(|points, capacity, count| {
        call!(mry_character_read_vertices(handle, character, points, ptr::null_mut(), ptr::null_mut(), capacity, count))
    })
}

pub(crate) fn character_vertex_bones(handle: &Handle, character: mry_character) -> Result<Vec<u32>> {
    sized_list(|bones, capacity, count| {
        call!(mry_character_read_vertices(handle, character, ptr::null_mut(), bones, ptr::null_mut(), capacity, count))
    })
}

pub(crate) fn character_set_joints(handle: &Handle, character: mry_character, places: &[mry_point]) -> Result<()> {
    call!(mry_character_set_joints(handle, character, places.as_ptr(), places.len())).map(drop)
}

pub(crate) fn character_to_json(handle: &Handle, character: mry_character) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_character_to_json(handle, character, text, capacity, size)))
}

pub(crate) fn character_write(handle: &Handle, character: mry_character, path: &str) -> Result<()> {
    call!(mry_character_write(handle, character, str(path))).map(drop)
}

pub(crate) fn character_write_preview(handle: &Handle, character: mry_character, path: &str) -> Result<()> {
    call!(mry_character_write_preview(handle, character, str(path))).map(drop)
}

pub(crate) fn poser_create(handle: &Handle, character: mry_character, deformer: &str, area: i32) -> Result<mry_poser> {
    let mut poser = mry_poser::default();
    call!(mry_poser_create(handle, character, str(deformer), area, &mut poser))?;
    Ok(poser)
}

pub(crate) fn poser_pose(
    handle: &Handle,
    poser: mry_poser,
    joints: &[mry_point],
    points: &mut [mry_point],
) -> Result<()> {
    call!(mry_poser_pose(handle, poser, joints.as_ptr(), joints.len(), points.as_mut_ptr(), points.len())).map(drop)
}

pub(crate) fn poser_drag(
    handle: &Handle,
    poser: mry_poser,
    joints: &[mry_point],
    points: &mut [mry_point],
) -> Result<()> {
    call!(mry_poser_drag(handle, poser, joints.as_ptr(), joints.len(), points.as_mut_ptr(), points.len())).map(drop)
}

pub(crate) fn poses_read(handle: &Handle, character: mry_character, path: &str) -> Result<mry_poses> {
    let mut poses = mry_poses::default();
    call!(mry_poses_read(handle, character, str(path), &mut poses))?;
    Ok(poses)
}

pub(crate) fn motion_read_bvh(handle: &Handle, path: &str, view: i32) -> Result<mry_motion> {
    let mut motion = mry_motion::default();
    call!(mry_motion_read_bvh(handle, str(path), view, 0, &mut motion))?;
    Ok(motion)
}

pub(crate) fn motion_write_bvh(handle: &Handle, motion: mry_motion, path: &str) -> Result<()> {
    call!(mry_motion_write_bvh(handle, motion, str(path))).map(drop)
}

/// Makes a description of `options` and hands it over while what it points at is alive.
fn carried<T>(options: &RetargetOptions<'_>, use_it: impl FnOnce(*const mry_retarget_desc) -> T) -> T {
    let planted: Vec<mry_str> = options.planted.iter().map(|name| str(name)).collect();
    let mut desc = sized!(mry_retarget_desc_init, mry_retarget_desc);
    (desc.angles, desc.reference) = (i32::from(options.absolute), options.reference);
    (desc.stretch, desc.root_scale) = (options.stretch, options.root_scale.unwrap_or(0.0));
    desc.in_place = u32::from(options.root_scale == Some(0.0));
    (desc.map, desc.planted, desc.planted_count) = (str(options.map), planted.as_ptr(), planted.len() as u64);
    use_it(&desc)
}

pub(crate) fn motion_retarget(
    handle: &Handle,
    motion: mry_motion,
    character: mry_character,
    options: &RetargetOptions<'_>,
) -> Result<mry_motion> {
    let mut made = mry_motion::default();
    carried(options, |desc| call!(mry_motion_retarget(handle, motion, character, desc, &mut made)))?;
    Ok(made)
}

pub(crate) fn motion_match(
    handle: &Handle,
    motion: mry_motion,
    character: mry_character,
    options: &RetargetOptions<'_>,
) -> Result<String> {
    carried(options, |desc| {
        sized_text(|text, capacity, size| {
            call!(mry_motion_match(handle, motion, character, desc, text, capacity, size))
        })
    })
}

pub(crate) fn start_take(
    handle: &Handle,
    (poses, character, motion): (mry_poses, mry_character, mry_motion),
    options: &TakeOptions<'_>,
) -> Result<mry_job> {
    let mut job = mry_job::default();
    carried(&options.retarget, |retarget| {
        let mut desc = sized!(mry_take_desc_init, mry_take_desc);
        (desc.poses, desc.character, desc.motion) = (poses, character, motion);
        (desc.area, desc.deformer, desc.retarget) = (options.area as i32, str(options.deformer), retarget);
        call!(mry_job_start_take(handle, &desc, &mut job))
    })?;
    Ok(job)
}

pub(crate) fn take_info(handle: &Handle, take: mry_take) -> Result<mry_take_info> {
    let mut info = sized!(mry_take_info_init, mry_take_info);
    call!(mry_take_get_info(handle, take, &mut info))?;
    Ok(info)
}

pub(crate) fn take_measure(handle: &Handle, take: mry_take, scale: f32, crop: bool) -> Result<(u32, u32, mry_point)> {
    let (mut width, mut height, mut corner) = (0, 0, mry_point::default());
    call!(mry_take_measure(handle, take, scale, crop.into(), &mut width, &mut height, &mut corner))?;
    Ok((width, height, corner))
}

pub(crate) fn take_draw(
    handle: &Handle,
    take: mry_take,
    frame: u64,
    scale: f32,
    crop: bool,
) -> Result<(u32, u32, Vec<u8>)> {
    let (width, height, _) = take_measure(handle, take, scale, crop)?;
    let mut pixels = vec![0; 4 * width as usize * height as usize];
    let (at, capacity) = (pixels.as_mut_ptr(), pixels.len());
    call!(mry_take_draw_frame(handle, take, frame, scale, crop.into(), at, capacity, 0))?;
    Ok((width, height, pixels))
}

pub(crate) fn motion_from_json(handle: &Handle, json: &str) -> Result<mry_motion> {
    taken(|out| call!(mry_motion_from_json(handle, str(json), out)))
}

pub(crate) fn take_points(handle: &Handle, take: mry_take, frame: u64) -> Result<Vec<mry_point>> {
    sized_list(|points, capacity, count| call!(mry_take_read_points(handle, take, frame, points, capacity, count)))
}

pub(crate) fn take_joints(handle: &Handle, take: mry_take, frame: u64) -> Result<Vec<mry_point>> {
    sized_list(|joints, capacity, count| call!(mry_take_read_joints(handle, take, frame, joints, capacity, count)))
}

pub(crate) fn take_report(handle: &Handle, take: mry_take) -> Result<String> {
    sized_text(|text, capacity, size| call!(mry_take_get_report(handle, take, text, capacity, size)))
}

pub(crate) fn start_take_file(handle: &Handle, take: mry_take, options: &TakeFileOptions<'_>) -> Result<mry_job> {
    let mut desc = sized!(mry_take_file_desc_init, mry_take_file_desc);
    (desc.take, desc.path, desc.format) = (take, str(options.path), str(options.format));
    (desc.crop, desc.scale, desc.background) = (u32::from(options.crop), options.scale, options.background);
    desc.name = str(options.name);
    let mut job = mry_job::default();
    call!(mry_job_start_take_file(handle, &desc, &mut job))?;
    Ok(job)
}
