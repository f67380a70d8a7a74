//! What pictures must show, on the CPU and, where an adapter can be had, on the GPU.

use glam::{Mat4, Vec3, vec3};
use image::RgbaImage;
use marey::Error;
use marey::export::animation::AnimationFormat;
use marey::job::Progress;
use marey::raster::{Rasterizer, Surface, clip_view};
use marey::shape::RiggedModel;
use marey::shape::creature::Creature;
use marey::shape::crowd::Crowd;
use marey_render::{Adapter, Camera, Extent, Film, Instance, Lens, Model, Picture, Renderer, Scene, Style};

mod common;

use common::{animal, herd, square};

/// The CPU, and the GPU where there is one.
fn renderers() -> Vec<Renderer> {
    let cpu = Renderer::new(Adapter::Cpu).expect("the CPU is always there");
    std::iter::once(cpu).chain(gpu()).collect()
}

fn gpu() -> Option<Renderer> {
    #[cfg(feature = "gpu")]
    match Renderer::new(Adapter::Gpu) {
        Ok(renderer) => return Some(renderer),
        #[expect(clippy::print_stderr, reason = "a person should know what was not tested")]
        Err(error) => eprintln!("not tested on a GPU: {error}"),
    }
    None
}

fn draw(renderer: &Renderer, scene: &Scene, frame: usize, picture: &Picture) -> RgbaImage {
    renderer.draw(scene, frame, picture, Progress::new().whole()).expect("drawn")
}

fn scene(model: RiggedModel) -> Scene {
    Scene::of(Model::new(model).expect("a valid model"))
}

fn extent(scene: &Scene) -> Extent {
    scene.extent(Progress::new().whole()).expect("measured")
}

/// Over the pixels of the squares' clip.
fn over_clip() -> Picture {
    Picture::new((64, 48), Camera::of_clip((64, 48), (64, 48)))
}

/// The mean difference of the channels, and the share of pixels that differ by more than 40.
fn difference(a: &RgbaImage, b: &RgbaImage) -> (f64, f64) {
    assert_eq!(a.dimensions(), b.dimensions());
    let pixels = f64::from(a.width() * a.height());
    let (mut sum, mut far) = (0_u64, 0_u64);
    for (a, b) in a.pixels().zip(b.pixels()) {
        // What cannot be seen has no colour to differ in.
        let seen =
            |p: &image::Rgba<u8>, c: usize| u32::from(p.0[c]) * if c < 3 { u32::from(p.0[3]) } else { 255 } / 255;
        let apart = [0, 1, 2, 3].map(|c| seen(a, c).abs_diff(seen(b, c)));
        sum += apart.iter().map(|d| u64::from(*d)).sum::<u64>();
        far += u64::from(apart.iter().any(|d| *d > 40));
    }
    (sum as f64 / pixels / 4.0, far as f64 / pixels)
}

#[test]
fn the_clips_view_covers_the_pixels_of_the_silhouette() {
    let model = animal(3000, 8);
    let scene = scene(model.clone());
    for renderer in renderers() {
        for frame in [0, 5] {
            let camera = Camera::of_clip(model.size, model.size);
            let drawn = draw(&renderer, &scene, frame, &Picture { smooth: false, ..Picture::new(model.size, camera) });
            let mut silhouette = Rasterizer::new(model.size.0, model.size.1);
            for mesh in model.pose(frame) {
                silhouette.draw(&mesh, &clip_view(model.size.1), Surface::Bare, 1);
            }
            let (mut covered, mut wrong) = (0, 0);
            for (x, y, p) in drawn.enumerate_pixels() {
                let inside = silhouette.id.get(x as usize, y as usize) == 1;
                covered += u32::from(inside);
                wrong += u32::from(inside != (p.0[3] == 255));
            }
            // Edges that pass through a pixel's centre may fall either way.
            assert!(covered > 10_000 && wrong * 1000 < covered, "{}: {wrong} of {covered}", renderer.describe());
        }
    }
}

#[test]
fn cpu_and_gpu_draw_the_same() {
    let (cpu, Some(gpu)) = (Renderer::new(Adapter::Cpu).expect("the CPU"), gpu()) else { return };
    let scene = herd(&Model::new(animal(2400, 12)).expect("valid"), 3);
    let extent = extent(&scene);
    let size = (300, 200);
    for (style, name) in Style::ALL {
        for (yaw, pitch, fov) in
            [(0.0, 0.0, None), (90.0, 5.0, Some(40.0)), (-35.0, 55.0, Some(25.0)), (200.0, -20.0, None)]
        {
            let camera = Camera::around(&extent, yaw, pitch, fov, size);
            let picture = Picture { style, shadow: 0.4, background: [40, 80, 120, 160], ..Picture::new(size, camera) };
            let (a, b) = (draw(&cpu, &scene, 3, &picture), draw(&gpu, &scene, 3, &picture));
            let (mean, far) = difference(&a, &b);
            assert!(mean < 1.5 && far < 0.02, "{name} from {yaw}, {pitch}: {mean:.2} on the mean, {far:.4} far off");
        }
    }
}

#[test]
fn what_is_nearer_hides_what_is_farther_from_either_side() {
    let square = |z: f32, color| Model::new(square(vec3(32.0, 24.0, z), 20.0, color)).expect("valid");
    let (red, blue) = (square(10.0, [250, 0, 0]), square(-10.0, [0, 0, 250]));
    for renderer in renderers() {
        for order in [[&red, &blue], [&blue, &red]] {
            let scene = Scene { instances: order.map(|m| Instance::new(m.clone())).to_vec(), ..Scene::of(red.clone()) };
            for style in [Style::Textured, Style::Shaded] {
                for (yaw, near) in [(0.0, 0), (180.0, 2)] {
                    let mut picture = Picture { style, ..over_clip() };
                    picture.camera.yaw = yaw;
                    let p = draw(&renderer, &scene, 0, &picture).get_pixel(32, 24).0;
                    assert!(p[near] > 100 && p[2 - near] == 0 && p[3] == 255, "{}: {p:?}", renderer.describe());
                }
            }
            // Nearest is white, farthest black.
            let picture = Picture { style: Style::Depth, ..over_clip() };
            assert!(draw(&renderer, &scene, 0, &picture).get_pixel(32, 24).0[0] > 230);
        }
    }
}

#[test]
fn what_nothing_covers_is_clear_and_edges_keep_their_colour() {
    let scene = scene(square(vec3(32.25, 24.0, 0.0), 21.0, [200, 100, 50]));
    for renderer in renderers() {
        let drawn = draw(&renderer, &scene, 0, &over_clip());
        let at = |x: u32, y: u32| drawn.get_pixel(x, y).0;
        assert!([at(0, 0), at(63, 0), at(0, 47), at(63, 47)].iter().all(|p| *p == [0; 4]));
        assert_eq!(at(32, 24), [200, 100, 50, 255]);
        let edge: Vec<[u8; 4]> = drawn.pixels().map(|p| p.0).filter(|p| p[3] > 0 && p[3] < 255).collect();
        assert!(edge.len() > 20, "{} smooth pixels", edge.len());
        for p in edge {
            // A quarter of 8 bits is what the colour was kept in.
            assert!((0..3).all(|c| p[c].abs_diff([200, 100, 50][c]) <= 2), "{p:?}");
        }
        let behind = Picture { background: [0, 0, 255, 255], ..over_clip() };
        let drawn = draw(&renderer, &scene, 0, &behind);
        assert_eq!(drawn.get_pixel(0, 0).0, [0, 0, 255, 255]);
        assert!(drawn.pixels().all(|p| p.0[3] == 255));
    }
}

#[test]
fn a_wireframe_has_lines_along_edges_and_none_between() {
    let scene = scene(square(vec3(32.0, 24.0, 0.0), 40.0, [200, 100, 50]));
    for renderer in renderers() {
        let drawn = draw(&renderer, &scene, 0, &Picture { style: Style::Wireframe, ..over_clip() });
        let red = |x: u32, y: u32| drawn.get_pixel(x, y).0[0];
        // Along the diagonal, which goes up to the right, and beside it.
        assert!((14..50).all(|i| red(i, 55 - i) < 100), "{}", renderer.describe());
        assert!(red(20, 12) > 150 && red(44, 36) > 150);
        assert!(red(12, 20) < 130 && red(51, 20) < 130);
    }
}

#[test]
fn styles_say_what_they_promise() {
    let scene = scene(animal(3000, 8));
    for renderer in renderers() {
        let shot = |style: Style, yaw: f32| {
            let camera = Camera::around(&extent(&scene), yaw, 0.0, None, (200, 150));
            draw(&renderer, &scene, 0, &Picture { style, smooth: false, ..Picture::new((200, 150), camera) })
        };
        let mean = |picture: &RgbaImage, of: &dyn Fn([u8; 4]) -> f32| {
            let seen: Vec<f32> = picture.pixels().filter(|p| p.0[3] == 255).map(|p| of(p.0)).collect();
            seen.iter().sum::<f32>() / seen.len() as f32
        };
        // Surfaces that are seen face the viewer.
        let normals = shot(Style::Normals, 40.0);
        assert!(mean(&normals, &|p| f32::from(p[2])) > 190.0);
        // The body is bright, the thin legs are dark.
        let radius = shot(Style::Radius, 0.0);
        let brightest = radius.pixels().map(|p| u32::from(p.0[1])).max().unwrap_or(0);
        let feet = (100..140).flat_map(|y| (0..200).map(move |x| (x, y)));
        let feet = feet.map(|(x, y)| radius.get_pixel(x, y).0).filter(|p| p[3] == 255).map(|p| u32::from(p[1]));
        assert!(brightest > 180 && feet.max().is_some_and(|green| green < 150), "{brightest}");
        // Limbs have different colours, and bones are drawn over them.
        let bones = shot(Style::Bones, 0.0);
        let colors: std::collections::HashSet<[u8; 3]> =
            bones.pixels().filter(|p| p.0[3] == 255).map(|p| [p.0[0] / 64, p.0[1] / 64, p.0[2] / 64]).collect();
        assert!(colors.len() > 8, "{} colours", colors.len());
    }
}

#[test]
fn shadows_darken_the_floor_and_are_not_seen_from_below() {
    let scene = scene(animal(1500, 4));
    let extent = extent(&scene);
    for renderer in renderers() {
        let dark = |pitch: f32, shadow: f32, style: Style| {
            let camera = Camera::around(&extent, 20.0, pitch, None, (200, 160));
            let picture = Picture { shadow, style, background: [255; 4], ..Picture::new((200, 160), camera) };
            let drawn = draw(&renderer, &scene, 0, &picture);
            drawn.pixels().filter(|p| p.0[0] == p.0[1] && p.0[1] == p.0[2] && p.0[0].abs_diff(128) < 3).count()
        };
        assert!(dark(35.0, 0.5, Style::Textured) > 500);
        assert_eq!(dark(35.0, 0.0, Style::Textured), 0);
        assert_eq!(dark(-35.0, 0.5, Style::Textured), 0);
    }
}

#[test]
fn a_fitted_camera_shows_all_of_the_animation_and_little_else() {
    let scene = scene(animal(1500, 12));
    let extent = extent(&scene);
    let cpu = Renderer::new(Adapter::Cpu).expect("the CPU");
    let size = (160, 120);
    for (yaw, pitch, fov) in
        [(0.0, 0.0, None), (70.0, 30.0, Some(35.0)), (160.0, 80.0, Some(70.0)), (20.0, -40.0, None)]
    {
        let camera = Camera::around(&extent, yaw, pitch, fov, size);
        let turning = Camera::turning(&extent, yaw, pitch, fov, size);
        let (mut low, mut high) = ((size.0, size.1), (0, 0));
        for frame in 0..12 {
            let drawn = draw(&cpu, &scene, frame, &Picture::new(size, camera));
            for (x, y, _) in drawn.enumerate_pixels().filter(|p| p.2.0[3] > 0) {
                (low, high) = ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)));
            }
            let around = Camera { yaw: yaw + 30.0 * frame as f32, ..turning };
            let drawn = draw(&cpu, &scene, frame, &Picture::new(size, around));
            let border = drawn.enumerate_pixels().filter(|(x, y, _)| *x == 0 || *y == 0 || *x == 159 || *y == 119);
            assert!(border.into_iter().all(|p| p.2.0[3] == 0), "{yaw} {pitch} {fov:?} turned {frame}");
        }
        assert!(low.0 > 0 && low.1 > 0 && high.0 < 159 && high.1 < 119, "{low:?} {high:?}");
        let fill = ((high.0 - low.0) as f32 / 160.0).max((high.1 - low.1) as f32 / 120.0);
        assert!(fill > 0.85, "{yaw} {pitch} {fov:?}: {fill}");
    }
}

#[test]
fn a_turntable_closes() {
    let scene = scene(animal(1500, 6));
    let camera = Camera::turning(&extent(&scene), 15.0, 20.0, Some(35.0), (120, 90));
    let film = Film { frames: 12, turns: 1.0, ..Film::of(&scene, Picture::new((120, 90), camera)) };
    for renderer in renderers() {
        let at = |index: usize| {
            let (frame, picture) = film.at(&scene, index);
            draw(&renderer, &scene, frame, &picture)
        };
        assert_eq!(at(0), at(12), "{}", renderer.describe());
        assert!(difference(&at(0), &at(6)).0 > 2.0);
    }
}

#[test]
fn a_camera_inside_sees_what_is_before_it() {
    let scene = scene(animal(1500, 2));
    for renderer in renderers() {
        let lens = Lens::Perspective { fov: 80.0, distance: 1.0 };
        let camera = Camera { yaw: 90.0, pitch: 0.0, target: vec3(150.0, 132.0, 0.0), lens };
        let drawn = draw(&renderer, &scene, 0, &Picture::new((80, 60), camera));
        // In the body, the wall is all around.
        let covered = drawn.pixels().filter(|p| p.0[3] == 255).count();
        assert!(covered > 80 * 60 * 9 / 10, "{}: {covered}", renderer.describe());
    }
}

#[test]
fn a_crowd_stands_where_it_is_placed() {
    let crowd = Crowd::herd(std::sync::Arc::new(Creature::from(animal(900, 6))), 4, 6);
    let scene = Scene::of_crowd(&crowd).expect("valid");
    assert_eq!((scene.instances.len(), scene.frames), (4, 6));
    let one = Scene { instances: scene.instances[..1].to_vec(), ..scene.clone() };
    let camera = Camera::around(&extent(&scene), 60.0, 40.0, None, (240, 180));
    for renderer in renderers() {
        let covered = |scene: &Scene| {
            draw(&renderer, scene, 2, &Picture::new((240, 180), camera)).pixels().filter(|p| p.0[3] > 127).count()
        };
        assert!(covered(&scene) > 2 * covered(&one), "{} {}", covered(&scene), covered(&one));
    }
}

#[test]
fn fine_textures_far_away_become_their_mean() {
    let mut model = square(vec3(32.0, 24.0, 0.0), 30.0, [0; 3]);
    model.parts[0].texture = image::RgbImage::from_fn(512, 512, |x, y| image::Rgb([((x + y) % 2 * 255) as u8; 3]));
    let scene = scene(model);
    for renderer in renderers() {
        let drawn = draw(&renderer, &scene, 0, &over_clip());
        let inside = (20..44).flat_map(|x| (12..36).map(move |y| (x, y)));
        for (x, y) in inside {
            let value = drawn.get_pixel(x, y).0[0];
            assert!(value.abs_diff(128) < 12, "{}: {value} at {x}, {y}", renderer.describe());
        }
    }
}

#[test]
fn any_number_of_threads_draws_the_same_bits() {
    let scene = herd(&Model::new(animal(1200, 6)).expect("valid"), 3);
    let camera = Camera::around(&extent(&scene), 30.0, 20.0, Some(40.0), (200, 150));
    let cpu = Renderer::new(Adapter::Cpu).expect("the CPU");
    for style in [Style::Shaded, Style::Bones] {
        let picture = Picture { style, shadow: 0.5, ..Picture::new((200, 150), camera) };
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| draw(&cpu, &scene, 1, &picture))
        };
        assert_eq!(with(1), with(5));
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_by_name() {
    let scene = scene(square(vec3(32.0, 24.0, 0.0), 20.0, [9; 3]));
    let good = over_clip();
    let camera = |change: &dyn Fn(&mut Camera)| {
        let mut picture = good;
        change(&mut picture.camera);
        picture
    };
    let far_away =
        Scene { instances: vec![Instance { place: Mat4::NAN, ..scene.instances[0].clone() }], ..scene.clone() };
    let cases: [(&str, &Scene, usize, Picture); 12] = [
        ("0x48", &scene, 0, Picture { size: (0, 48), ..good }),
        ("99999999", &scene, 0, Picture { size: (64, 99_999_999), ..good }),
        ("camera", &scene, 0, camera(&|c| c.yaw = f32::NAN)),
        ("camera", &scene, 0, camera(&|c| c.target = Vec3::INFINITY)),
        ("height", &scene, 0, camera(&|c| c.lens = Lens::Parallel { height: 0.0 })),
        ("distance", &scene, 0, camera(&|c| c.lens = Lens::Perspective { fov: 30.0, distance: -1.0 })),
        ("180 degrees", &scene, 0, camera(&|c| c.lens = Lens::Perspective { fov: 180.0, distance: 9.0 })),
        ("shadow", &scene, 0, Picture { shadow: 2.0, ..good }),
        ("shadow", &scene, 0, Picture { shadow: f32::NAN, ..good }),
        ("frame 1", &scene, 1, good),
        ("empty", &Scene::default(), 0, good),
        ("instance 0", &far_away, 0, good),
    ];
    for renderer in renderers() {
        for (says, scene, frame, picture) in &cases {
            let refused = renderer.draw(scene, *frame, picture, Progress::new().whole());
            let message = refused.expect_err(says).to_string();
            assert!(message.contains(says), "{says}: {message}");
        }
    }
    let mut empty = animal(300, 1);
    empty.animation.clear();
    assert!(Model::new(empty).is_err());
    assert!(Style::named("cubist").expect_err("no style").to_string().contains("wireframe"));
}

#[test]
fn what_the_device_cannot_hold_it_says_and_the_cpu_draws() {
    let Some(gpu) = gpu() else { return };
    let scene = scene(square(vec3(32.0, 24.0, 0.0), 20.0, [9; 3]));
    // One row more than most devices hold; where one holds it, it draws it.
    let picture = Picture { size: (16_384, 1), smooth: false, ..over_clip() };
    let stage = Progress::new();
    match gpu.draw(&scene, 0, &picture, stage.whole()) {
        Ok(drawn) => assert_eq!(drawn.dimensions(), (16_384, 1)),
        Err(error) => assert!(error.to_string().contains("on the CPU"), "{error}"),
    }
    let auto = Renderer::new(Adapter::Auto).expect("there is always something");
    auto.draw(&scene, 0, &picture, stage.whole()).expect("drawn");
}

#[test]
fn films_are_written_whole_or_not_at_all() {
    let scene = scene(animal(600, 5));
    let camera = Camera::turning(&extent(&scene), 0.0, 10.0, None, (64, 48));
    let film = Film { turns: 1.0, ..Film::of(&scene, Picture::new((64, 48), camera)) };
    let folder = tempfile::tempdir().expect("a folder");
    let cpu = Renderer::new(Adapter::Cpu).expect("the CPU");
    let path = folder.path().join("turn.png");
    let files = film.write(&cpu, &scene, &path, AnimationFormat::Apng, Progress::new().whole()).expect("written");
    assert_eq!(files, std::slice::from_ref(&path));
    let clip = marey::clip::Clip::open(&path).expect("read back");
    assert_eq!((clip.info().frames, clip.info().width, clip.info().height), (5, 64, 48));

    let before = std::fs::read(&path).expect("read");
    let cancelled = Progress::new();
    cancelled.cancel();
    let refused = film.write(&cpu, &scene, &path, AnimationFormat::Apng, cancelled.whole());
    assert!(matches!(refused, Err(Error::Cancelled)));
    let missing = folder.path().join("missing/turn.gif");
    assert!(film.write(&cpu, &scene, &missing, AnimationFormat::Gif, Progress::new().whole()).is_err());
    let none = Film { frames: 0, ..film };
    assert!(none.write(&cpu, &scene, &path, AnimationFormat::Apng, Progress::new().whole()).is_err());
    assert_eq!(std::fs::read(&path).expect("read"), before);
    assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 1);
}

#[test]
fn a_film_that_is_cancelled_half_way_stops_and_leaves_nothing() {
    let scene = scene(animal(3000, 400));
    let camera = Camera::of_clip((320, 240), (320, 240));
    let film = Film::of(&scene, Picture::new((320, 240), camera));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("long.gif");
    let progress = Progress::new();
    let cpu = Renderer::new(Adapter::Cpu).expect("the CPU");
    std::thread::scope(|threads| {
        threads.spawn(|| {
            while progress.fraction() < 0.05 {
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
            progress.cancel();
        });
        let ended = film.write(&cpu, &scene, &path, AnimationFormat::Gif, progress.whole());
        assert!(matches!(ended, Err(Error::Cancelled)), "{ended:?}");
    });
    assert!(progress.fraction() < 0.9);
    assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 0);
}

/// A studio draws into textures of its own, on its own device.
#[cfg(feature = "gpu")]
#[test]
fn a_host_draws_into_its_own_texture() {
    use marey_render::gpu::Gpu;
    use marey_render::wgpu;
    let Some(renderer) = gpu() else { return };
    let ours = renderer.gpu().expect("a GPU");
    let (device, queue) = (ours.device().clone(), ours.queue().clone());
    let studio = Gpu::with_device(device.clone(), queue.clone()).expect("a device like ours");
    let scene = scene(animal(1500, 3));
    let camera = Camera::around(&extent(&scene), 30.0, 10.0, Some(40.0), (128, 96));
    let picture = Picture { style: Style::Shaded, background: [30, 30, 30, 255], ..Picture::new((128, 96), camera) };
    let size = wgpu::Extent3d { width: 128, height: 96, depth_or_array_layers: 1 };
    let format = wgpu::TextureFormat::Bgra8Unorm;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    studio.draw_into(&texture.create_view(&Default::default()), format, &scene, 1, &picture).expect("drawn");
    let back = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 128 * 96 * 4,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(512), rows_per_image: None };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), wgpu::TexelCopyBufferInfo { buffer: &back, layout }, size);
    queue.submit([encoder.finish()]);
    back.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let bytes = back.get_mapped_range(..).expect("mapped");
    let seen = RgbaImage::from_fn(128, 96, |x, y| {
        let at = 4 * (y as usize * 128 + x as usize);
        image::Rgba([bytes[at + 2], bytes[at + 1], bytes[at], bytes[at + 3]])
    });
    assert_eq!(seen, draw(&renderer, &scene, 1, &picture));
}
