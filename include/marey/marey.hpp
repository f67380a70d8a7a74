/*
 * marey.hpp: marey.h for C++17. Header-only: it adds no symbols, and the library's ABI stays that of marey.h.
 *
 *   marey::context context;
 *   marey::clip clip = context.open("horse.mp4");
 *   marey::rig rig = context.read_rig("strokes.json");
 *   context.run_creature(clip, rig).write_glb("horse.glb");
 *
 * Handles own their object, move and do not copy; they keep their context alive, so the order of their ends does not
 * matter. A moved-from handle holds no object: only destroying it and assigning to it are of use. Strings are UTF-8.
 * Calls may be made from any thread, as marey.h says.
 *
 * A failure is thrown as marey::error. With MAREY_NO_EXCEPTIONS defined, or exceptions switched off, nothing is thrown:
 * every call gives a marey::expected instead of its value, which is that value or the error.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */
#ifndef MAREY_MAREY_HPP
#define MAREY_MAREY_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <marey/marey.h>

#if !defined(MAREY_NO_EXCEPTIONS) && !defined(__cpp_exceptions)
#define MAREY_NO_EXCEPTIONS
#endif

namespace marey {

/** Why a call failed. */
class error : public std::runtime_error {
public:
  /** From the detail that a call has filled, with the status that it returned. */
  error(mry_status status, const mry_error &detail)
    : std::runtime_error(detail.message[0] != '\0' ? detail.message : mry_status_text(status)), status_(status),
      param_(detail.param) {}

  /** MRY_E_INPUT, ...; or MRY_CANCELLED of a job that was waited for. Accept ones you do not know. */
  mry_status status() const noexcept { return status_; }
  /** The parameter at fault, as marey.h names it; empty where no single one is. */
  const std::string &param() const noexcept { return param_; }

private:
  mry_status status_;
  std::string param_;
};

/** A value, or the error that stands in its way. */
template <class T> class [[nodiscard]] expected {
public:
  using value_type = std::conditional_t<std::is_void_v<T>, std::monostate, T>;

  expected(value_type value) : held_(std::in_place_index<0>, std::move(value)) {}
  expected(marey::error error) : held_(std::in_place_index<1>, std::move(error)) {}

  /** Whether there is a value. */
  explicit operator bool() const noexcept { return held_.index() == 0; }
  /** The value; only where there is one. */
  value_type &operator*() noexcept { return *std::get_if<0>(&held_); }
  const value_type &operator*() const noexcept { return *std::get_if<0>(&held_); }
  value_type *operator->() noexcept { return std::get_if<0>(&held_); }
  /** The error; only where there is no value. */
  const marey::error &error() const noexcept { return *std::get_if<1>(&held_); }

private:
  std::variant<value_type, marey::error> held_;
};

/** What a call that may fail gives. */
#ifdef MAREY_NO_EXCEPTIONS
template <class T> using result = expected<T>;
#else
template <class T> using result = T;
#endif

/** The library's version, such as "0.1.0". */
inline std::string_view version() { return mry_version_string(); }

/** @cond */
namespace detail {

/** Calls, and makes the answer of what the call has filled. */
template <class Call, class Make> auto perform(Call call, Make make) -> result<decltype(make())> {
  mry_error detail = MRY_ERROR_INIT;
  const mry_status status = call(&detail);
  if (status == MRY_OK) {
#ifdef MAREY_NO_EXCEPTIONS
    if constexpr (std::is_void_v<decltype(make())>) {
      make();
      return std::monostate{};
    } else {
      return make();
    }
#else
    return make();
#endif
  }
#ifdef MAREY_NO_EXCEPTIONS
  return error(status, detail);
#else
  throw error(status, detail);
#endif
}

template <class Call> result<void> perform(Call call) {
  return perform(call, [] {});
}

inline mry_str str(std::string_view text) noexcept { return mry_str{ text.data(), text.size() }; }

/** A list that says how long it is when there is too little room. */
template <class T, class Read> result<std::vector<T>> list(Read read) {
  std::vector<T> values(64);
  std::size_t count = 0;
  const auto fill = [&](mry_error *err) {
    mry_status status = read(values.data(), values.size(), &count, err);
    if (status == MRY_E_BUFFER_TOO_SMALL) {
      values.resize(count);
      status = read(values.data(), values.size(), &count, err);
    }
    return status;
  };
  return perform(fill, [&] {
    values.resize(count);
    return std::move(values);
  });
}

/** Makes the answer of a text that says how long it is when there is too little room. */
template <class Read, class Make> auto text_with(Read read, Make make) {
  std::string characters(255, '\0');
  std::size_t size = 0;
  const auto fill = [&](mry_error *err) {
    mry_status status = read(characters.data(), characters.size() + 1, &size, err);
    if (status == MRY_E_BUFFER_TOO_SMALL) {
      characters.resize(size - 1);
      status = read(characters.data(), size, &size, err);
    }
    return status;
  };
  return perform(fill, [&] {
    characters.resize(size - 1);
    return make(std::move(characters));
  });
}

template <class Read> result<std::string> text(Read read) {
  return text_with(read, [](std::string characters) { return characters; });
}

/** A context and what must live as long. */
struct state {
  state() = default;
  state(const state &) = delete;
  state &operator=(const state &) = delete;
  ~state() { mry_context_destroy(context); }

  mry_context *context = nullptr;
  std::function<void(std::int32_t, std::string_view)> log;

  static void take_line(std::int32_t level, mry_str message, void *user) noexcept {
    static_cast<state *>(user)->log(level, std::string_view(message.data, message.len));
  }
};

/** Owns an object of a context. */
template <class Id, mry_status (*Destroy)(mry_context *, Id)> class handle {
public:
  handle() = default;
  handle(std::shared_ptr<state> context, Id id) noexcept : context_(std::move(context)), id_(id) {}
  handle(const handle &) = delete;
  handle &operator=(const handle &) = delete;
  handle(handle &&other) noexcept : context_(std::move(other.context_)), id_(std::exchange(other.id_, Id{})) {}
  handle &operator=(handle &&other) noexcept {
    handle old(std::move(*this));
    context_ = std::move(other.context_);
    id_ = std::exchange(other.id_, Id{});
    return *this;
  }
  ~handle() {
    if (context_) {
      Destroy(context_->context, id_);
    }
  }

  /** Whether it holds an object. */
  explicit operator bool() const noexcept { return id_.v != 0; }
  /** The id, for calls of marey.h. It stays the handle's. */
  Id id() const noexcept { return id_; }

protected:
  mry_context *c() const noexcept { return context_ ? context_->context : nullptr; }

  /** Another object of the context. */
  template <class Handle, class OtherId, class Call> result<Handle> other(Call call) const {
    OtherId id{};
    return perform([&](mry_error *err) { return call(&id, err); }, [&] { return Handle(context_, id); });
  }

  std::shared_ptr<state> context_;
  Id id_{};
};

} // namespace detail
/** @endcond */

/** A picture in the library's memory, shown without a copy until the end of this handle. */
class image_map : public detail::handle<mry_map, mry_unmap> {
public:
  image_map(std::shared_ptr<detail::state> context, const mry_image_view &view) noexcept
    : handle(std::move(context), view.map), view_(view) {}
  /** The picture; `data` is valid while this handle is. */
  const mry_image_view &view() const noexcept { return view_; }

private:
  mry_image_view view_;
};

/** A surface in the library's memory, shown without a copy until the end of this handle. */
class mesh_map : public detail::handle<mry_map, mry_unmap> {
public:
  mesh_map(std::shared_ptr<detail::state> context, const mry_mesh_view &view) noexcept
    : handle(std::move(context), view.map), view_(view) {}
  /** The surface; its lists are valid while this handle is. */
  const mry_mesh_view &view() const noexcept { return view_; }

private:
  mry_mesh_view view_;
};

/** A video, read-only. */
class clip : public detail::handle<mry_clip, mry_clip_close> {
public:
  using handle::handle;

  /** Size, frames, rate. */
  result<mry_clip_info> info() const {
    mry_clip_info info = MRY_CLIP_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_clip_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** When a frame is shown, in seconds from the first. */
  result<double> time(std::uint64_t frame) const {
    double seconds = 0.0;
    return detail::perform([&](mry_error *err) { return mry_clip_get_time(c(), id_, frame, &seconds, err); },
                           [&] { return seconds; });
  }
  /** One thing that a person should know about the clip; `index` is below warning_count. */
  result<std::string> warning(std::uint32_t index) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_clip_get_warning(c(), id_, index, text, capacity, size, err);
    });
  }
  /** How opaque a frame is, a byte a pixel, rows from the top without gaps; 255 for what hides all behind it. */
  result<std::vector<std::uint8_t>> alpha(std::uint64_t frame) const {
    mry_clip_info info = MRY_CLIP_INFO_INIT;
    std::vector<std::uint8_t> out;
    return detail::perform(
      [&](mry_error *err) {
        mry_status status = mry_clip_get_info(c(), id_, &info, err);
        if (status != MRY_OK) return status;
        out.resize(static_cast<std::size_t>(info.width) * info.height);
        return mry_clip_read_alpha(c(), id_, frame, out.data(), out.size(), 0, err);
      },
      [&] { return std::move(out); });
  }
  /** A decoded frame, without a copy. */
  result<image_map> map_frame(std::uint64_t frame) const {
    mry_image_view view = MRY_IMAGE_VIEW_INIT;
    return detail::perform([&](mry_error *err) { return mry_clip_map_frame(c(), id_, frame, &view, err); },
                           [&] { return image_map(context_, view); });
  }
};

/** What a person marks to capture the motion of a character. */
class joints : public detail::handle<mry_joints, mry_joints_destroy> {
public:
  using handle::handle;

  /** Marks a joint on a frame, in place of an earlier mark there. */
  result<void> mark(std::string_view name, std::uint64_t frame, float x, float y, float width, float height) {
    return detail::perform([&](mry_error *err) {
      return mry_joints_mark(c(), id_, detail::str(name), frame, x, y, width, height, err);
    });
  }
  /** Takes a joint's mark on a frame back. */
  result<void> unmark(std::string_view name, std::uint64_t frame) {
    return detail::perform(
      [&](mry_error *err) { return mry_joints_unmark(c(), id_, detail::str(name), frame, err); });
  }
  /** Adds a bone between two marked joints. */
  result<void> add_bone(std::string_view parent, std::string_view child) {
    return detail::perform([&](mry_error *err) {
      return mry_joints_add_bone(c(), id_, detail::str(parent), detail::str(child), err);
    });
  }
  /** Whether jobs can work with them; with {} whatever the clip. */
  result<void> validate(mry_clip clip = {}) const {
    return detail::perform([&](mry_error *err) { return mry_joints_validate(c(), id_, clip, err); });
  }
  /** The text of a joints.json. */
  result<std::string> to_json() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_joints_to_json(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes joints.json. */
  result<void> write(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_joints_write(c(), id_, detail::str(path), err); });
  }
};

/** What a person marks to take a motion from a clip: control points and their keys. */
class control_points : public detail::handle<mry_control_points, mry_control_points_destroy> {
public:
  using handle::handle;

  /** Marks a point on a frame, in place of an earlier key there. */
  result<void> mark(std::string_view name, std::uint64_t frame, mry_point at) {
    return detail::perform(
      [&](mry_error *err) { return mry_control_points_mark(c(), id_, detail::str(name), frame, at, err); });
  }
  /** Takes a point's key on a frame back. */
  result<void> unmark(std::string_view name, std::uint64_t frame) {
    return detail::perform(
      [&](mry_error *err) { return mry_control_points_unmark(c(), id_, detail::str(name), frame, err); });
  }
  /** Whether jobs can work with them; with {} whatever the clip. */
  result<void> validate(mry_clip clip = {}) const {
    return detail::perform([&](mry_error *err) { return mry_control_points_validate(c(), id_, clip, err); });
  }
  /** The text of a points.json. */
  result<std::string> to_json() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_control_points_to_json(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes points.json. */
  result<void> write(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_control_points_write(c(), id_, detail::str(path), err); });
  }
};

/** A vector drawing: strokes with their pens and fills. */
class drawing : public detail::handle<mry_drawing, mry_drawing_destroy> {
public:
  using handle::handle;

  /** A stroke with its name. */
  struct stroke {
    std::string name;
    mry_drawing_stroke what;
  };

  /** Size and counts. */
  result<mry_drawing_info> info() const {
    mry_drawing_info info = MRY_DRAWING_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_drawing_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** A stroke; the farthest is 0. */
  result<stroke> get_stroke(std::uint32_t index) const {
    stroke found{ {}, MRY_DRAWING_STROKE_INIT };
    return detail::text_with(
      [&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
        return mry_drawing_get_stroke(c(), id_, index, text, capacity, size, &found.what, err);
      },
      [&](std::string name) {
        found.name = std::move(name);
        return found;
      });
  }
  /** What the drawing's file had that it does not hold, in a sentence. */
  result<std::string> left_out(std::uint32_t index) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_drawing_get_left_out(c(), id_, index, text, capacity, size, err);
    });
  }
  /** Adds a stroke over the others, as a pen drew it; the colour is red, green, blue, alpha. */
  result<void> add_stroke(std::string_view name, const std::vector<mry_pen_sample> &samples, float width,
                          const std::array<std::uint8_t, 4> &rgba) {
    return detail::perform([&](mry_error *err) {
      return mry_drawing_add_stroke(c(), id_, detail::str(name), samples.data(), samples.size(), width, rgba.data(),
                                    err);
    });
  }
  /** Takes a stroke away. */
  result<void> remove_stroke(std::string_view name) {
    return detail::perform(
      [&](mry_error *err) { return mry_drawing_remove_stroke(c(), id_, detail::str(name), err); });
  }
  /** The outline around it, a closed polygon. */
  result<std::vector<mry_point>> outline() const {
    return detail::list<mry_point>([&](mry_point *points, std::size_t capacity, std::size_t *count, mry_error *err) {
      return mry_drawing_read_outline(c(), id_, points, capacity, count, err);
    });
  }
  /** The text of an SVG file. */
  result<std::string> to_svg() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_drawing_to_svg(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes an SVG file. */
  result<void> write_svg(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_drawing_write_svg(c(), id_, detail::str(path), err); });
  }
};

/** How motions hold a drawing: points, pins, stiff strokes, layers and joints. */
class binding : public detail::handle<mry_binding, mry_binding_destroy> {
public:
  using handle::handle;

  /** A tracked point that holds the drawing. */
  struct point {
    std::string track;
    std::uint32_t index;
    mry_point at;
  };
  /** A motion's name and how it is used. */
  struct motion_use {
    std::string name;
    mry_motion_use how;
  };
  /** How a stroke is treated. */
  struct stroke_use {
    float rigidity;
    bool decoration;
  };

  /** Counts. */
  result<mry_binding_info> info() const {
    mry_binding_info info = MRY_BINDING_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_binding_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** Whether a sketch can be made of it and a drawing. */
  result<void> validate(const drawing &drawing) const {
    return detail::perform([&](mry_error *err) { return mry_binding_validate(c(), id_, drawing.id(), err); });
  }
  /** The text of a bind.json. */
  result<std::string> to_json() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_binding_to_json(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes bind.json. */
  result<void> write(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_binding_write(c(), id_, detail::str(path), err); });
  }
  /** Says how a motion is used; a new name adds one behind the others. */
  result<void> set_motion(std::string_view name, const mry_motion_use &how) {
    return detail::perform(
      [&](mry_error *err) { return mry_binding_set_motion(c(), id_, detail::str(name), &how, err); });
  }
  /** How a motion is used. */
  result<motion_use> get_motion(std::uint32_t index) const {
    motion_use found{ {}, MRY_MOTION_USE_INIT };
    return detail::text_with(
      [&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
        return mry_binding_get_motion(c(), id_, index, text, capacity, size, &found.how, err);
      },
      [&](std::string name) {
        found.name = std::move(name);
        return found;
      });
  }
  /** Says where a tracked point holds the drawing; motion empty for the first, layer empty for the nearest. */
  result<void> set_point(std::string_view track, mry_point at, std::uint32_t index = 0, std::string_view motion = {},
                         std::string_view layer = {}) {
    return detail::perform([&](mry_error *err) {
      return mry_binding_set_point(c(), id_, detail::str(motion), detail::str(track), index, at, detail::str(layer),
                                   err);
    });
  }
  /** Lets a tracked point hold the drawing no longer. */
  result<void> remove_point(std::string_view track, std::uint32_t index = 0, std::string_view motion = {}) {
    return detail::perform([&](mry_error *err) {
      return mry_binding_remove_point(c(), id_, detail::str(motion), detail::str(track), index, err);
    });
  }
  /** A tracked point that holds the drawing. */
  result<point> get_point(std::uint32_t index) const {
    point found{};
    return detail::text_with(
      [&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
        return mry_binding_get_point(c(), id_, index, text, capacity, size, &found.index, &found.at, err);
      },
      [&](std::string track) {
        found.track = std::move(track);
        return found;
      });
  }
  /** Pins a place; layer empty for the nearest. */
  result<void> add_pin(mry_point at, std::string_view layer = {}) {
    return detail::perform(
      [&](mry_error *err) { return mry_binding_add_pin(c(), id_, at, detail::str(layer), err); });
  }
  /** Takes a pin away. */
  result<void> remove_pin(std::uint32_t index) {
    return detail::perform([&](mry_error *err) { return mry_binding_remove_pin(c(), id_, index, err); });
  }
  /** Where a pin is. */
  result<mry_point> get_pin(std::uint32_t index) const {
    mry_point at{};
    return detail::perform([&](mry_error *err) { return mry_binding_get_pin(c(), id_, index, &at, err); },
                           [&] { return at; });
  }
  /** Says how a stroke is treated: how much more its shape is kept than by default, and whether it stands still. */
  result<void> set_stroke(std::string_view stroke, float rigidity, bool decoration = false) {
    return detail::perform([&](mry_error *err) {
      return mry_binding_set_stroke(c(), id_, detail::str(stroke), rigidity, decoration ? 1u : 0u, err);
    });
  }
  /** How a stroke is treated. */
  result<stroke_use> get_stroke(std::string_view stroke) const {
    stroke_use found{};
    std::uint32_t decoration = 0;
    return detail::perform(
      [&](mry_error *err) {
        return mry_binding_get_stroke(c(), id_, detail::str(stroke), &found.rigidity, &decoration, err);
      },
      [&] {
        found.decoration = decoration != 0;
        return found;
      });
  }
  /** Puts the strokes that a brush touches into a layer, and says how many. */
  result<std::uint32_t> paint_layer(const drawing &drawing, std::string_view layer,
                                    const std::vector<mry_point> &brush, float radius) {
    std::uint32_t count = 0;
    return detail::perform(
      [&](mry_error *err) {
        return mry_binding_paint_layer(c(), id_, drawing.id(), detail::str(layer), brush.data(), brush.size(), radius,
                                       &count, err);
      },
      [&] { return count; });
  }
  /** Puts strokes into a layer; a new name makes one in front of the others. */
  result<void> set_layer(const drawing &drawing, std::string_view layer, const std::vector<std::string> &strokes) {
    std::vector<mry_str> names;
    for (const std::string &stroke : strokes) {
      names.push_back(detail::str(stroke));
    }
    return detail::perform([&](mry_error *err) {
      return mry_binding_set_layer(c(), id_, drawing.id(), detail::str(layer), names.data(), names.size(), err);
    });
  }
  /** Writes a PNG of the drawing with numbers where tracked points hold it; clip {} for the drawing alone. */
  result<void> write_preview(const drawing &drawing, mry_motion motion, mry_clip clip, std::string_view path) const {
    return detail::perform([&](mry_error *err) {
      return mry_binding_write_preview(c(), id_, drawing.id(), motion, clip, detail::str(path), err);
    });
  }
  /** Takes a layer away. */
  result<void> remove_layer(std::string_view layer) {
    return detail::perform(
      [&](mry_error *err) { return mry_binding_remove_layer(c(), id_, detail::str(layer), err); });
  }
  /** The name of a layer; the farthest is 0. */
  result<std::string> get_layer(std::uint32_t index) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_binding_get_layer(c(), id_, index, text, capacity, size, err);
    });
  }
  /** Proposes joints where layers cross, in place of those that were there. */
  result<void> propose_joints(const drawing &drawing) {
    return detail::perform([&](mry_error *err) { return mry_binding_propose_joints(c(), id_, drawing.id(), err); });
  }
  /** Holds two layers together at a place. */
  result<void> add_joint(std::string_view layer, std::string_view other, mry_point at) {
    return detail::perform([&](mry_error *err) {
      return mry_binding_add_joint(c(), id_, detail::str(layer), detail::str(other), at, err);
    });
  }
  /** Moves a joint. */
  result<void> set_joint(std::uint32_t index, mry_point at) {
    return detail::perform([&](mry_error *err) { return mry_binding_set_joint(c(), id_, index, at, err); });
  }
  /** Takes a joint away. */
  result<void> remove_joint(std::uint32_t index) {
    return detail::perform([&](mry_error *err) { return mry_binding_remove_joint(c(), id_, index, err); });
  }
  /** Where a joint is. */
  result<mry_point> get_joint(std::uint32_t index) const {
    mry_point at{};
    return detail::perform([&](mry_error *err) { return mry_binding_get_joint(c(), id_, index, &at, err); },
                           [&] { return at; });
  }
};

/** A drawing in motion: paths, pixels and files of every frame. */
class sketch_take : public detail::handle<mry_sketch_take, mry_sketch_take_destroy> {
public:
  using handle::handle;

  /** Counts, rate and size. */
  result<mry_sketch_take_info> info() const {
    mry_sketch_take_info info = MRY_SKETCH_TAKE_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_sketch_take_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** The same at another time. */
  result<sketch_take> retime(const mry_retime_desc &how) const {
    return other<sketch_take, mry_sketch_take>(
      [&](mry_sketch_take *id, mry_error *err) { return mry_sketch_take_retime(c(), id_, &how, id, err); });
  }
  /** The order in which strokes are painted, the farthest first. */
  result<std::vector<std::uint32_t>> order() const {
    return detail::list<std::uint32_t>(
      [&](std::uint32_t *order, std::size_t capacity, std::size_t *count, mry_error *err) {
        return mry_sketch_take_read_order(c(), id_, order, capacity, count, err);
      });
  }
  /** The path of a stroke in a frame. */
  result<std::vector<mry_path_element>> stroke(std::uint64_t frame, std::uint32_t stroke) const {
    return detail::list<mry_path_element>(
      [&](mry_path_element *elements, std::size_t capacity, std::size_t *count, mry_error *err) {
        return mry_sketch_take_read_stroke(c(), id_, frame, stroke, elements, capacity, count, err);
      });
  }
  /** A frame, straight alpha. */
  struct picture {
    std::uint32_t width, height;
    /** 4 bytes a pixel: red, green, blue, alpha; rows without gaps. */
    std::vector<std::uint8_t> pixels;
  };
  /** Draws a frame, `scale` pixels a pixel of the drawing: the drawing's page where `crop`, else all of every frame. */
  result<picture> draw(std::uint64_t frame, float scale = 1.0f, bool crop = false) const {
    picture drawn{};
    const std::uint32_t cropped = crop ? 1u : 0u;
    const auto call = [&](mry_error *err) {
      const mry_status status =
        mry_sketch_take_measure(c(), id_, scale, cropped, &drawn.width, &drawn.height, nullptr, err);
      if (status != MRY_OK) {
        return status;
      }
      drawn.pixels.resize(std::size_t{ 4 } * drawn.width * drawn.height);
      return mry_sketch_take_draw_frame(c(), id_, frame, scale, cropped, drawn.pixels.data(), drawn.pixels.size(), 0,
                                        err);
    };
    return detail::perform(call, [&] { return std::move(drawn); });
  }
};

/** One frame of a creature as a closed surface in millimetres, z up. */
class solid : public detail::handle<mry_solid, mry_solid_destroy> {
public:
  using handle::handle;

  /** What it is, and what was done to make it. */
  result<mry_solid_info> info() const {
    mry_solid_info info = MRY_SOLID_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_solid_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** x, y, z of each vertex, in mm, and its red, green, blue. */
  struct vertices {
    std::vector<float> positions;
    std::vector<std::uint8_t> colours;
  };
  /** Its vertices. */
  result<vertices> read_vertices() const {
    vertices read{};
    const auto call = [&](mry_error *err) {
      std::size_t count = 0;
      const mry_status status = mry_solid_read_vertices(c(), id_, nullptr, nullptr, 0, &count, err);
      if (status != MRY_OK && status != MRY_E_BUFFER_TOO_SMALL) {
        return status;
      }
      read.positions.resize(3 * count);
      read.colours.resize(3 * count);
      return mry_solid_read_vertices(c(), id_, read.positions.data(), read.colours.data(), count, &count, err);
    };
    return detail::perform(call, [&] { return std::move(read); });
  }
  /** Three vertices for each triangle, counter-clockwise seen from outside. */
  result<std::vector<std::uint32_t>> read_triangles() const {
    std::vector<std::uint32_t> read;
    const auto call = [&](mry_error *err) {
      std::size_t count = 0;
      const mry_status status = mry_solid_read_triangles(c(), id_, nullptr, 0, &count, err);
      if (status != MRY_OK && status != MRY_E_BUFFER_TOO_SMALL) {
        return status;
      }
      read.resize(3 * count);
      return mry_solid_read_triangles(c(), id_, read.data(), count, &count, err);
    };
    return detail::perform(call, [&] { return std::move(read); });
  }
  /** Writes it as .stl or .3mf, whole or not at all. */
  result<void> write(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_solid_write(c(), id_, detail::str(path), err); });
  }
};

/** What a person draws on a clip. */
class rig : public detail::handle<mry_rig, mry_rig_destroy> {
public:
  using handle::handle;

  /** Adds a limb; gives its index. */
  result<std::uint32_t> add_limb(std::string_view label, std::int32_t side = MRY_SIDE_UNKNOWN) {
    std::uint32_t limb = 0;
    return detail::perform(
      [&](mry_error *err) { return mry_rig_add_limb(c(), id_, detail::str(label), side, &limb, err); },
      [&] { return limb; });
  }
  /** How many limbs there are. */
  result<std::uint32_t> limb_count() const {
    std::uint32_t count = 0;
    return detail::perform([&](mry_error *err) { return mry_rig_get_limb_count(c(), id_, &count, err); },
                           [&] { return count; });
  }
  /** A limb's label. */
  result<std::string> label(std::uint32_t limb) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_rig_get_limb(c(), id_, limb, text, capacity, size, nullptr, err);
    });
  }
  /** Says where a limb is in depth on a frame: MRY_SAID_DEPTH and MRY_SAID_BEND, or 0 to take it back. */
  result<void> set_depth(std::uint32_t limb, std::uint64_t frame, std::uint32_t said, float depth, float bend) {
    return detail::perform(
      [&](mry_error *err) { return mry_rig_set_depth(c(), id_, limb, frame, said, depth, bend, err); });
  }
  /** Draws a limb on a frame, instead of what was drawn of it there before. */
  result<void> set_stroke(std::uint32_t limb, std::uint64_t frame, const std::vector<mry_point> &points,
                          std::int32_t facing = MRY_FACING_UNKNOWN) {
    return detail::perform([&](mry_error *err) {
      return mry_rig_set_stroke(c(), id_, limb, frame, points.data(), points.size(), facing, err);
    });
  }
  /** A limb's stroke on a key frame. */
  result<std::vector<mry_point>> stroke(std::uint32_t limb, std::uint64_t frame) const {
    return detail::list<mry_point>([&](mry_point *points, std::size_t capacity, std::size_t *count, mry_error *err) {
      return mry_rig_get_stroke(c(), id_, limb, frame, points, capacity, count, nullptr, err);
    });
  }
  /** Takes a limb's stroke off a frame. */
  result<void> remove_stroke(std::uint32_t limb, std::uint64_t frame) {
    return detail::perform([&](mry_error *err) { return mry_rig_remove_stroke(c(), id_, limb, frame, err); });
  }
  /** The key frames, rising. */
  result<std::vector<std::uint64_t>> keyframes() const {
    return detail::list<std::uint64_t>(
      [&](std::uint64_t *frames, std::size_t capacity, std::size_t *count, mry_error *err) {
        return mry_rig_get_keyframes(c(), id_, frames, capacity, count, err);
      });
  }
  /** Paints a hint for the segmenter. */
  result<void> add_paint(std::uint64_t frame, std::int32_t kind, float radius, const std::vector<mry_point> &points) {
    return detail::perform([&](mry_error *err) {
      return mry_rig_add_paint(c(), id_, frame, kind, radius, points.data(), points.size(), err);
    });
  }
  /** Takes all paint off a frame. */
  result<void> clear_paint(std::uint64_t frame) {
    return detail::perform([&](mry_error *err) { return mry_rig_clear_paint(c(), id_, frame, err); });
  }
  /** Gives the whole mask of a frame as an image file; empty to take it off. */
  result<void> set_mask(std::uint64_t frame, std::string_view path) {
    return detail::perform([&](mry_error *err) { return mry_rig_set_mask(c(), id_, frame, detail::str(path), err); });
  }
  /** Gives the whole mask of a frame as pixels, a byte each without gaps, which are written to a PNG file. */
  result<void> paint_mask(std::uint64_t frame, const std::vector<std::uint8_t> &pixels, std::string_view path) {
    return detail::perform([&](mry_error *err) {
      return mry_rig_paint_mask(c(), id_, frame, pixels.data(), pixels.size(), 0, detail::str(path), err);
    });
  }
  /** The longest drawn length of a limb, in clip pixels. */
  result<float> length_hint(std::uint32_t limb) const {
    float length = 0.0f;
    return detail::perform([&](mry_error *err) { return mry_rig_get_length_hint(c(), id_, limb, &length, err); },
                           [&] { return length; });
  }
  /** Fails with what is missing or wrong for jobs on `clip`. */
  result<void> validate(const marey::clip &clip) const {
    return detail::perform([&](mry_error *err) { return mry_rig_validate(c(), id_, clip.id(), err); });
  }
  /** The text of a strokes.json. */
  result<std::string> to_json() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_rig_to_json(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes strokes.json, whole or not at all. */
  result<void> write(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_rig_write(c(), id_, detail::str(path), err); });
  }
};

/** Where a track is in one frame: three lists of one length. */
struct track_frame {
  /** Places, which may lie outside the image. */
  std::vector<mry_point> points;
  /** 1 where the point is seen. */
  std::vector<std::uint8_t> visible;
  /** How far each place is to be trusted, 0..1. */
  std::vector<float> confidence;
};

/** Limbs over time. */
class motion : public detail::handle<mry_motion, mry_motion_destroy> {
public:
  using handle::handle;

  /** Size, tracks, frames. */
  result<mry_motion_info> info() const {
    mry_motion_info info = MRY_MOTION_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_motion_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** A track's name. */
  result<std::string> track_name(std::uint32_t track) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_motion_get_track(c(), id_, track, text, capacity, size, nullptr, nullptr, err);
    });
  }
  /** The track of a name. */
  result<std::uint32_t> find_track(std::string_view name) const {
    std::uint32_t track = 0;
    return detail::perform(
      [&](mry_error *err) { return mry_motion_find_track(c(), id_, detail::str(name), &track, err); },
      [&] { return track; });
  }
  /** Where a track is in one frame. */
  result<track_frame> frame(std::uint32_t track, std::uint64_t frame) const {
    track_frame out;
    std::size_t count = 0;
    const auto read = [&](mry_error *err) {
      mry_status status = mry_motion_read_frame(c(), id_, track, frame, nullptr, nullptr, nullptr, 0, &count, err);
      if (status != MRY_OK) {
        return status;
      }
      out.points.resize(count);
      out.visible.resize(count);
      out.confidence.resize(count);
      return mry_motion_read_frame(c(), id_, track, frame, out.points.data(), out.visible.data(),
                                   out.confidence.data(), count, &count, err);
    };
    return detail::perform(read, [&] { return std::move(out); });
  }
  /** The strokes that would help most, at most `most`, the most helpful first. */
  result<std::vector<mry_correction>> corrections(const marey::rig &rig, std::uint32_t most) const {
    std::vector<mry_correction> found;
    const auto read = [&](mry_error *err) -> mry_status {
      for (std::uint32_t i = 0; i < most; i++) {
        mry_correction next = MRY_CORRECTION_INIT;
        const mry_status status = mry_motion_get_correction(c(), id_, rig.id(), i, &next, err);
        if (status != MRY_OK) {
          return status == MRY_E_NOT_FOUND ? static_cast<mry_status>(MRY_OK) : status;
        }
        found.push_back(next);
      }
      return MRY_OK;
    };
    return detail::perform(read, [&] { return std::move(found); });
  }
  /** A copy, to change; tracks are copied when they are changed. */
  result<motion> copy() const {
    return other<motion, mry_motion>([&](mry_motion *id, mry_error *err) { return mry_motion_copy(c(), id_, id, err); });
  }
  /** Adds a track, all its points at (0, 0), hidden and not to be trusted; gives its index. */
  result<std::uint32_t> add_track(std::string_view name, std::int32_t kind, std::size_t point_count) {
    std::uint32_t track = 0;
    return detail::perform(
      [&](mry_error *err) { return mry_motion_add_track(c(), id_, detail::str(name), kind, point_count, &track, err); },
      [&] { return track; });
  }
  /** Removes a track and its bones. */
  result<void> remove_track(std::uint32_t track) {
    return detail::perform([&](mry_error *err) { return mry_motion_remove_track(c(), id_, track, err); });
  }
  /** Sets where a track is in one frame. Empty lists of visible and confidence mean all seen, all certain. */
  result<void> set_frame(std::uint32_t track, std::uint64_t frame, const track_frame &to) {
    const auto set = [&](mry_error *err) {
      const std::size_t count = to.points.size();
      // Lists of unlike lengths are refused by a count that no track has.
      const bool odd = (!to.visible.empty() && to.visible.size() != count) ||
                       (!to.confidence.empty() && to.confidence.size() != count);
      return mry_motion_set_frame(c(), id_, track, frame, to.points.data(),
                                  to.visible.empty() ? nullptr : to.visible.data(),
                                  to.confidence.empty() ? nullptr : to.confidence.data(), odd ? 0 : count, err);
    };
    return detail::perform(set);
  }
  /** Joins two tracks: the child hangs from the parent. */
  result<void> add_bone(std::uint32_t parent, std::uint32_t child) {
    return detail::perform([&](mry_error *err) { return mry_motion_add_bone(c(), id_, parent, child, err); });
  }
  /** Takes a bone away. */
  result<void> remove_bone(std::uint32_t bone) {
    return detail::perform([&](mry_error *err) { return mry_motion_remove_bone(c(), id_, bone, err); });
  }
  /** After how many frames all of it moves the same way again. */
  result<mry_cycle> find_cycle() const {
    mry_cycle cycle = MRY_CYCLE_INIT;
    return detail::perform([&](mry_error *err) { return mry_motion_find_cycle(c(), id_, &cycle, err); },
                           [&] { return cycle; });
  }
  /** When in its cycle each track's end is farthest along its swing, and how many pixels it swings. */
  result<std::vector<std::pair<double, double>>> phases() const {
    std::vector<double> phases, swings;
    std::size_t count = 0;
    const auto read = [&](mry_error *err) {
      const mry_status status = mry_motion_read_phases(c(), id_, nullptr, nullptr, 0, &count, err);
      if (status != MRY_OK) {
        return status;
      }
      phases.resize(count);
      swings.resize(count);
      return mry_motion_read_phases(c(), id_, phases.data(), swings.data(), count, &count, err);
    };
    return detail::perform(read, [&] {
      std::vector<std::pair<double, double>> both(count);
      for (std::size_t i = 0; i < count; i++) {
        both[i] = { phases[i], swings[i] };
      }
      return both;
    });
  }
  /** A range of it closed into a loop; `seam`, where it is given, says how. */
  result<motion> close_loop(const mry_loop_desc &how, mry_seam *seam = nullptr) const {
    return other<motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_motion_loop(c(), id_, &how, id, seam, err); });
  }
  /** Without jitter, through its key frames. */
  result<motion> smooth(const mry_smooth_desc &how) const {
    return other<motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_motion_smooth(c(), id_, &how, id, err); });
  }
  /** With feet that stay where they come down. */
  result<motion> plant(const mry_plant_desc &how) const {
    return other<motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_motion_plant(c(), id_, &how, id, err); });
  }
  /** When feet are down and how they slide, as JSON. */
  result<std::string> contacts(const mry_plant_desc &how) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_motion_get_contacts(c(), id_, &how, text, capacity, size, err);
    });
  }
  /** At another time. */
  result<motion> retime(const mry_retime_desc &how) const {
    return other<motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_motion_retime(c(), id_, &how, id, err); });
  }
  /** On the limbs of the creature whose own motion is given. */
  result<motion> map_limbs(const motion &creature, const mry_limb_map_desc &how) const {
    return other<motion, mry_motion>([&](mry_motion *id, mry_error *err) {
      return mry_motion_map_limbs(c(), id_, creature.id(), &how, id, err);
    });
  }
  /** Which of the creature's limbs follows what, as the text of a limb map. */
  result<std::string> match_limbs(const motion &creature, const mry_limb_map_desc &how) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_motion_match_limbs(c(), id_, creature.id(), &how, text, capacity, size, err);
    });
  }
  /** The text of a motion.json. */
  result<std::string> to_json() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_motion_to_json(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes motion.json, whole or not at all. */
  result<void> write(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_motion_write(c(), id_, detail::str(path), err); });
  }
};

/** Which pixels are the creature's, frame by frame. */
class masks : public detail::handle<mry_masks, mry_masks_destroy> {
public:
  using handle::handle;

  /** Size and number. */
  result<mry_masks_info> info() const {
    mry_masks_info info = MRY_MASKS_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_masks_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** One mask: a byte a pixel, 0 or 255, rows from the top without gaps. */
  result<std::vector<std::uint8_t>> frame(std::uint64_t frame) const {
    std::vector<std::uint8_t> pixels;
    const auto read = [&](mry_error *err) {
      mry_masks_info info = MRY_MASKS_INFO_INIT;
      const mry_status status = mry_masks_get_info(c(), id_, &info, err);
      if (status != MRY_OK) {
        return status;
      }
      pixels.resize(std::size_t{ info.width } * info.height);
      return mry_masks_read(c(), id_, frame, pixels.data(), pixels.size(), 0, err);
    };
    return detail::perform(read, [&] { return std::move(pixels); });
  }
  /** Writes 00000.png, ... and a report, whole or not at all. */
  result<void> write(std::string_view folder) const {
    return detail::perform([&](mry_error *err) { return mry_masks_write_folder(c(), id_, detail::str(folder), err); });
  }
};

/** How a creature is posed. */
struct reposing {
  /** MRY_LENGTHS_DEFAULT, ... */
  std::int32_t lengths = MRY_LENGTHS_DEFAULT;
  /** A limb gets at most this many times its length; 0 for 1.25. */
  float stretch = 0.0f;
  /** For motions: what the way of the roots is scaled by; 0 for the ratio of the limbs' lengths. */
  float root_scale = 0.0f;
  /** For motions: whether the roots stay where they are. */
  bool in_place = false;
  /** For motions: whether left and right change places. */
  bool mirror = false;
  /** For key poses: how many frames to make; 0 for up to the last key. */
  std::uint64_t frames = 0;
  /** For motions: MRY_TURNS_DEFAULT, ... */
  std::int32_t turns = MRY_TURNS_DEFAULT;

  /** The description for the C library. */
  mry_repose_desc desc() const {
    mry_repose_desc desc = MRY_REPOSE_DESC_INIT;
    desc.lengths = lengths;
    desc.stretch = stretch;
    desc.root_scale = root_scale;
    desc.in_place = in_place ? 1u : 0u;
    desc.mirror = mirror ? 1u : 0u;
    desc.frames = frames;
    desc.turns = turns;
    return desc;
  }
};

/** A textured mesh on animated bones. */
class creature : public detail::handle<mry_creature, mry_creature_destroy> {
public:
  using handle::handle;

  /** Counts, frames, rate. */
  result<mry_creature_info> info() const {
    mry_creature_info info = MRY_CREATURE_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_creature_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** The same at another time; its folder cannot be written. */
  result<creature> retime(const mry_retime_desc &how) const {
    return other<creature, mry_creature>(
      [&](mry_creature *id, mry_error *err) { return mry_creature_retime(c(), id_, &how, id, err); });
  }
  /** The motion that drives it. */
  result<marey::motion> motion() const {
    return other<marey::motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_creature_get_motion(c(), id_, id, err); });
  }
  /** The masks it was built from. */
  result<marey::masks> masks() const {
    return other<marey::masks, mry_masks>(
      [&](mry_masks *id, mry_error *err) { return mry_creature_get_masks(c(), id_, id, err); });
  }
  /** The text of the report of the job that made it. */
  result<std::string> report() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_creature_get_report(c(), id_, text, capacity, size, err);
    });
  }
  /** A part's name: the limb's label. */
  result<std::string> part_name(std::uint32_t part) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_creature_get_part(c(), id_, part, text, capacity, size, nullptr, err);
    });
  }
  /** A limb's label. */
  result<std::string> limb_label(std::uint32_t limb) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_creature_get_limb(c(), id_, limb, text, capacity, size, nullptr, err);
    });
  }
  /** What a limb is, which bones carry it, and what it hangs from. */
  result<mry_creature_limb> limb_info(std::uint32_t limb) const {
    mry_creature_limb info = MRY_CREATURE_LIMB_INIT;
    std::size_t size = 0;
    return detail::perform(
      [&](mry_error *err) { return mry_creature_get_limb(c(), id_, limb, nullptr, 0, &size, &info, err); },
      [&] { return info; });
  }
  /** A bone's name. */
  result<std::string> bone_name(std::uint32_t bone) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_creature_get_bone(c(), id_, bone, text, capacity, size, nullptr, err);
    });
  }
  /** All bones in one frame, or in MRY_REST_POSE. */
  result<std::vector<mry_transform>> pose(std::uint64_t frame) const {
    return detail::list<mry_transform>(
      [&](mry_transform *transforms, std::size_t capacity, std::size_t *count, mry_error *err) {
        return mry_creature_read_pose(c(), id_, frame, transforms, capacity, count, err);
      });
  }
  /** All bones in the pose of limbs that are drawn anew. */
  result<std::vector<mry_transform>> pose_along(const std::vector<mry_limb_pose> &limbs, const reposing &how = {}) const {
    const mry_repose_desc desc = how.desc();
    return detail::list<mry_transform>(
      [&](mry_transform *transforms, std::size_t capacity, std::size_t *count, mry_error *err) {
        return mry_creature_pose(c(), id_, limbs.data(), limbs.size(), &desc, transforms, capacity, count, err);
      });
  }
  /** The creature moving from key pose to key pose: the text of a strokes.json. */
  result<creature> repose(std::string_view poses, const reposing &how = {}) const {
    const mry_repose_desc desc = how.desc();
    return other<creature, mry_creature>([&](mry_creature *id, mry_error *err) {
      return mry_creature_repose(c(), id_, detail::str(poses), &desc, id, err);
    });
  }
  /** The creature moving as a motion does; the text of a map.json says which limb follows what, or names do. */
  result<creature> drive(const marey::motion &motion, std::string_view map = {}, const reposing &how = {}) const {
    const mry_repose_desc desc = how.desc();
    return other<creature, mry_creature>([&](mry_creature *id, mry_error *err) {
      return mry_creature_drive(c(), id_, motion.id(), detail::str(map), &desc, id, err);
    });
  }
  /** Which limb follows what of a motion, as the text of a map.json. */
  result<std::string> matched(const marey::motion &motion, std::string_view map = {}) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_creature_match(c(), id_, motion.id(), detail::str(map), text, capacity, size, err);
    });
  }
  /** How hard the animation pulls the limbs, as JSON. */
  result<std::string> strain() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_creature_get_strain(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes the textures of all parts into a folder as PNG pictures, all or none. */
  result<void> write_textures(std::string_view folder) const {
    return detail::perform(
      [&](mry_error *err) { return mry_creature_write_textures(c(), id_, detail::str(folder), err); });
  }
  /** The creature with the textures that are in a folder, as write_textures names them. */
  result<creature> with_textures(std::string_view folder) const {
    return other<creature, mry_creature>([&](mry_creature *id, mry_error *err) {
      return mry_creature_read_textures(c(), id_, detail::str(folder), id, err);
    });
  }
  /** A part's surface in one frame, or in MRY_REST_POSE, without a copy. */
  result<mesh_map> map_part(std::uint32_t part, std::uint64_t frame) const {
    mry_mesh_view view = MRY_MESH_VIEW_INIT;
    return detail::perform([&](mry_error *err) { return mry_creature_map_part(c(), id_, part, frame, &view, err); },
                           [&] { return mesh_map(context_, view); });
  }
  /** A part's texture, without a copy. */
  result<image_map> map_texture(std::uint32_t part) const {
    mry_image_view view = MRY_IMAGE_VIEW_INIT;
    return detail::perform([&](mry_error *err) { return mry_creature_map_texture(c(), id_, part, &view, err); },
                           [&] { return image_map(context_, view); });
  }
  /** Writes a glTF 2.0 binary, whole or not at all. `scale` is metres a world unit. */
  result<void> write_glb(std::string_view path, float scale = 1.0f) const {
    return detail::perform(
      [&](mry_error *err) { return mry_creature_write_glb(c(), id_, detail::str(path), scale, err); });
  }
  /** Writes OBJ files, whole or not at all. */
  result<void> write_obj(std::string_view folder) const {
    return detail::perform([&](mry_error *err) { return mry_creature_write_obj(c(), id_, detail::str(folder), err); });
  }
  /** Writes everything into a folder, whole or not at all. */
  result<void> write_folder(std::string_view folder, bool obj = false, float scale = 1.0f) const {
    return detail::perform([&](mry_error *err) {
      return mry_creature_write_folder(c(), id_, detail::str(folder), obj ? 1u : 0u, scale, err);
    });
  }
  /** A picture: RGBA, rows from the top, colours not multiplied by alpha. */
  result<std::vector<std::uint8_t>> render(const mry_render_desc &desc) const {
    return detail::list<std::uint8_t>(
      [&](std::uint8_t *pixels, std::size_t capacity, std::size_t *count, mry_error *err) {
        return mry_creature_render(c(), id_, &desc, pixels, capacity, count, err);
      });
  }
  /** Draws pictures over time into a file, whole or not at all; with turns the camera goes around. */
  result<void> write_film(std::string_view path, const mry_render_desc &desc, float turns = 0.0f) const {
    mry_render_file_desc file = MRY_RENDER_FILE_DESC_INIT;
    file.creature = id_;
    file.path = detail::str(path);
    file.picture = &desc;
    file.turns = turns;
    return detail::perform([&](mry_error *err) { return mry_run_render(c(), &file, err); });
  }
};

/** Creatures many times over, each at its own place and time. */
class crowd : public detail::handle<mry_crowd, mry_crowd_destroy> {
public:
  using handle::handle;

  /** Counts, frames, rate. */
  result<mry_crowd_info> info() const {
    mry_crowd_info info = MRY_CROWD_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_crowd_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** Writes one glTF 2.0 binary, whole or not at all. `scale` is metres a world unit. */
  result<void> write_glb(std::string_view path, float scale = 1.0f) const {
    return detail::perform(
      [&](mry_error *err) { return mry_crowd_write_glb(c(), id_, detail::str(path), scale, err); });
  }
};

/** Long work that goes on beside the host. Its end cancels what has not ended. */
class job : public detail::handle<mry_job, mry_job_destroy> {
public:
  using handle::handle;

  /** How it is doing. Never waits. */
  result<mry_job_state> poll() const {
    mry_job_state state = MRY_JOB_STATE_INIT;
    return detail::perform([&](mry_error *err) { return mry_job_poll(c(), id_, &state, err); }, [&] { return state; });
  }
  /** Waits for its end. Fails as the job did, and with MRY_CANCELLED when it was cancelled. */
  result<void> wait() const {
    return detail::perform([&](mry_error *err) { return mry_job_wait(c(), id_, MRY_FOREVER, err); });
  }
  /** Waits for its end, at most so long; whether it has come. Fails as wait() does. */
  result<bool> wait_for(std::chrono::nanoseconds time) const {
    const auto ns = static_cast<std::uint64_t>(time.count() < 0 ? 0 : time.count());
    bool ended = true;
    const auto wait = [&](mry_error *err) {
      const mry_status status = mry_job_wait(c(), id_, ns, err);
      ended = status != MRY_PENDING;
      return ended ? status : static_cast<mry_status>(MRY_OK);
    };
    return detail::perform(wait, [&] { return ended; });
  }
  /** Asks it to stop; returns at once. */
  result<void> cancel() {
    return detail::perform([&](mry_error *err) { return mry_job_cancel(c(), id_, err); });
  }
  /** Takes the clip that an open job opened; once. */
  result<marey::clip> take_clip() {
    return other<marey::clip, mry_clip>(
      [&](mry_clip *id, mry_error *err) { return mry_job_take_clip(c(), id_, id, err); });
  }
  /** Takes the motion that it made; once. */
  result<marey::motion> take_motion() {
    return other<marey::motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_job_take_motion(c(), id_, id, err); });
  }
  /** Takes the masks that it made; once. */
  result<marey::masks> take_masks() {
    return other<marey::masks, mry_masks>(
      [&](mry_masks *id, mry_error *err) { return mry_job_take_masks(c(), id_, id, err); });
  }
  /** Takes the control points that it proposed; once. */
  result<marey::control_points> take_control_points() {
    return other<marey::control_points, mry_control_points>(
      [&](mry_control_points *id, mry_error *err) { return mry_job_take_control_points(c(), id_, id, err); });
  }
  /** Takes the binding that a bind job made; once. */
  result<marey::binding> take_binding() {
    return other<marey::binding, mry_binding>(
      [&](mry_binding *id, mry_error *err) { return mry_job_take_binding(c(), id_, id, err); });
  }
  /** Takes the drawing in motion that it made; once. */
  result<marey::sketch_take> take_sketch_take() {
    return other<marey::sketch_take, mry_sketch_take>(
      [&](mry_sketch_take *id, mry_error *err) { return mry_job_take_sketch_take(c(), id_, id, err); });
  }
  /** Takes the solid that a print job made; once. */
  result<marey::solid> take_solid() {
    return other<marey::solid, mry_solid>(
      [&](mry_solid *id, mry_error *err) { return mry_job_take_solid(c(), id_, id, err); });
  }
  /** The text of its report, where it makes one. */
  result<std::string> report() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_job_get_report(c(), id_, text, capacity, size, err);
    });
  }
  /** Takes the creature that it made; once. */
  result<marey::creature> take_creature() {
    return other<marey::creature, mry_creature>(
      [&](mry_creature *id, mry_error *err) { return mry_job_take_creature(c(), id_, id, err); });
  }
};

/** How a motion is carried over to a character. Lists and texts are copied. */
struct carrying {
  /** MRY_ANGLES_RELATIVE or MRY_ANGLES_ABSOLUTE. */
  std::int32_t angles = MRY_ANGLES_RELATIVE;
  /** The frame of the motion that the character at rest corresponds to. */
  std::uint64_t reference = 0;
  /** Bones change their length up to this factor; 0 for 3. */
  float stretch = 0.0f;
  /** What the way of the roots is scaled by; 0 for the ratio of the figures' sizes. */
  float root_scale = 0.0f;
  /** Whether the roots stay where they are. */
  bool in_place = false;
  /** The text of a map.json; empty to match by names or by likeness. */
  std::string map;
  /** Joints that stay where they come down. */
  std::vector<std::string> planted;

  /** Calls with a description that lives as long. */
  template <class Call> auto with(Call call) const {
    std::vector<mry_str> names;
    for (const std::string &name : planted) {
      names.push_back(detail::str(name));
    }
    mry_retarget_desc desc = MRY_RETARGET_DESC_INIT;
    desc.angles = angles;
    desc.reference = reference;
    desc.stretch = stretch;
    desc.root_scale = root_scale;
    desc.in_place = in_place ? 1u : 0u;
    desc.map = detail::str(map);
    desc.planted = names.data();
    desc.planted_count = names.size();
    return call(&desc);
  }
};

/** A character bound to its skeleton: joints in, the mesh out. */
class poser : public detail::handle<mry_poser, mry_poser_destroy> {
public:
  using handle::handle;

  /** The mesh with the joints where they are said to be; `shape` has a place for every vertex. */
  result<void> pose(const std::vector<mry_point> &joints, std::vector<mry_point> &shape) {
    return detail::perform([&](mry_error *err) {
      return mry_poser_pose(c(), id_, joints.data(), joints.size(), shape.data(), shape.size(), err);
    });
  }
  /** The vertices of a pose that a redrawn stretch of the outline moves, and how far, for poses::set_moved. */
  result<std::vector<std::pair<std::uint32_t, mry_point>>> redraw(const std::vector<mry_point> &joints,
                                                                  const std::vector<mry_point> &shape,
                                                                  const std::vector<mry_point> &curve) {
    std::vector<std::uint32_t> vertices(shape.size());
    std::vector<mry_point> ways(shape.size());
    std::size_t count = 0;
    const auto call = [&](mry_error *err) {
      return mry_poser_redraw(c(), id_, joints.data(), joints.size(), shape.data(), shape.size(), curve.data(),
                              curve.size(), vertices.data(), ways.data(), vertices.size(), &count, err);
    };
    return detail::perform(call, [&] {
      std::vector<std::pair<std::uint32_t, mry_point>> moved;
      for (std::size_t i = 0; i < count; i++) {
        moved.emplace_back(vertices[i], ways[i]);
      }
      return moved;
    });
  }
  /** The same on from the pose before, while the pointer moves: many times as fast, and within a pixel. */
  result<void> drag(const std::vector<mry_point> &joints, std::vector<mry_point> &shape) {
    return detail::perform([&](mry_error *err) {
      return mry_poser_drag(c(), id_, joints.data(), joints.size(), shape.data(), shape.size(), err);
    });
  }
};

/** Key poses of a character over time. */
class poses : public detail::handle<mry_poses, mry_poses_destroy> {
public:
  using handle::handle;

  /** Counts and rate. */
  result<mry_poses_info> info() const {
    mry_poses_info info = MRY_POSES_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_poses_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** Sets the rate. */
  result<void> set_rate(double fps, std::uint32_t step = 1) {
    return detail::perform([&](mry_error *err) { return mry_poses_set_rate(c(), id_, fps, step, err); });
  }
  /** Sets the joints of a frame, which becomes a key. */
  result<void> set_key(std::uint64_t frame, const std::vector<mry_point> &joints,
                       std::int32_t easing = MRY_EASING_LINEAR) {
    return detail::perform([&](mry_error *err) {
      return mry_poses_set_key(c(), id_, frame, joints.data(), joints.size(), easing, err);
    });
  }
  /** Takes a key away. */
  result<void> remove_key(std::uint64_t frame) {
    return detail::perform([&](mry_error *err) { return mry_poses_remove_key(c(), id_, frame, err); });
  }
  /** The joints of a key, which counts by rising frames. */
  result<std::vector<mry_point>> key(std::uint64_t index) const {
    return detail::list<mry_point>([&](mry_point *joints, std::size_t capacity, std::size_t *count, mry_error *err) {
      return mry_poses_get_key(c(), id_, index, nullptr, nullptr, joints, capacity, count, err);
    });
  }
  /** Sets the vertices that a key drags by hand, in place of those set before. */
  result<void> set_moved(std::uint64_t frame, const std::vector<std::pair<std::uint32_t, mry_point>> &moved) {
    std::vector<std::uint32_t> vertices;
    std::vector<mry_point> ways;
    for (const auto &[vertex, way] : moved) {
      vertices.push_back(vertex);
      ways.push_back(way);
    }
    return detail::perform([&](mry_error *err) {
      return mry_poses_set_moved(c(), id_, frame, vertices.data(), ways.data(), vertices.size(), err);
    });
  }
  /** Sets how near to the viewer a bone's region is from a key to the next. */
  result<void> set_depth(std::uint64_t frame, std::uint32_t bone, std::int32_t depth) {
    return detail::perform([&](mry_error *err) { return mry_poses_set_depth(c(), id_, frame, bone, depth, err); });
  }
  /** The text of a poses.json. */
  result<std::string> to_json() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_poses_to_json(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes poses.json, whole or not at all. */
  result<void> write(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_poses_write(c(), id_, detail::str(path), err); });
  }
};

/** A character in every frame. */
class take : public detail::handle<mry_take, mry_take_destroy> {
public:
  using handle::handle;

  /** Counts, rate and bounds. */
  result<mry_take_info> info() const {
    mry_take_info info = MRY_TAKE_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_take_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** The same at another time. */
  result<take> retime(const mry_retime_desc &how) const {
    return other<take, mry_take>(
      [&](mry_take *id, mry_error *err) { return mry_take_retime(c(), id_, &how, id, err); });
  }
  /** The mesh in a frame. */
  result<std::vector<mry_point>> points(std::uint64_t frame) const {
    return detail::list<mry_point>([&](mry_point *points, std::size_t capacity, std::size_t *count, mry_error *err) {
      return mry_take_read_points(c(), id_, frame, points, capacity, count, err);
    });
  }
  /** The joints in a frame. */
  result<std::vector<mry_point>> joints(std::uint64_t frame) const {
    return detail::list<mry_point>([&](mry_point *joints, std::size_t capacity, std::size_t *count, mry_error *err) {
      return mry_take_read_joints(c(), id_, frame, joints, capacity, count, err);
    });
  }
  /** The text of the report of the job that made it. */
  result<std::string> report() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_take_get_report(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes it in the format that the path's ending says, whole or not at all. */
  result<void> write(std::string_view path, std::string_view format = {}, float scale = 1.0f) const {
    mry_take_file_desc desc = MRY_TAKE_FILE_DESC_INIT;
    desc.take = id_;
    desc.path = detail::str(path);
    desc.format = detail::str(format);
    desc.scale = scale;
    return detail::perform([&](mry_error *err) { return mry_run_take_file(c(), &desc, err); });
  }
};

/** A cut-out drawing with a skeleton. */
class character : public detail::handle<mry_character, mry_character_destroy> {
public:
  using handle::handle;

  /** Size and counts. */
  result<mry_character_info> info() const {
    mry_character_info info = MRY_CHARACTER_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_character_get_info(c(), id_, &info, err); },
                           [&] { return info; });
  }
  /** The mesh's vertices at rest. */
  result<std::vector<mry_point>> vertices() const {
    return detail::list<mry_point>([&](mry_point *points, std::size_t capacity, std::size_t *count, mry_error *err) {
      return mry_character_read_vertices(c(), id_, points, nullptr, nullptr, capacity, count, err);
    });
  }
  /** The name of a joint. */
  result<std::string> joint_name(std::uint32_t joint) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_character_get_joint(c(), id_, joint, text, capacity, size, nullptr, err);
    });
  }
  /** The joint of a name. Fails with MRY_E_NOT_FOUND where there is none. */
  result<std::uint32_t> find_joint(std::string_view name) const {
    std::uint32_t joint = 0;
    return detail::perform(
      [&](mry_error *err) { return mry_character_find_joint(c(), id_, detail::str(name), &joint, err); },
      [&] { return joint; });
  }
  /** Moves all joints at rest. */
  result<void> set_joints(const std::vector<mry_point> &places) {
    return detail::perform(
      [&](mry_error *err) { return mry_character_set_joints(c(), id_, places.data(), places.size(), err); });
  }
  /** Adds a joint with a bone from another one to it; gives its index. */
  result<std::uint32_t> add_joint(std::string_view name, mry_point at, std::uint32_t parent) {
    std::uint32_t joint = 0;
    return detail::perform(
      [&](mry_error *err) { return mry_character_add_joint(c(), id_, detail::str(name), at, parent, &joint, err); },
      [&] { return joint; });
  }
  /** The pose that strokes draw, for joints that were at `from`. */
  result<std::vector<mry_point>> sketch(const std::vector<mry_point> &from,
                                        const std::vector<std::vector<mry_point>> &strokes) const {
    std::vector<mry_point> points, joints(from.size());
    std::vector<std::uint32_t> lengths;
    for (const auto &stroke : strokes) {
      points.insert(points.end(), stroke.begin(), stroke.end());
      lengths.push_back(static_cast<std::uint32_t>(stroke.size()));
    }
    const auto call = [&](mry_error *err) {
      return mry_character_sketch(c(), id_, from.data(), from.size(), points.data(), lengths.data(), lengths.size(),
                                  joints.data(), err);
    };
    return detail::perform(call, [&] { return std::move(joints); });
  }
  /** Brings the hindmost region at a place of a pose before the others there; gives its bone. */
  result<std::uint32_t> bring_forward(const std::vector<mry_point> &shape, std::vector<std::int32_t> &depths,
                                      mry_point at) const {
    std::uint32_t bone = 0;
    const auto call = [&](mry_error *err) {
      return mry_character_bring_forward(c(), id_, shape.data(), shape.size(), depths.data(), depths.size(), at, &bone,
                                         err);
    };
    return detail::perform(call, [&] { return bone; });
  }
  /** Takes a joint away. */
  result<void> remove_joint(std::uint32_t joint) {
    return detail::perform([&](mry_error *err) { return mry_character_remove_joint(c(), id_, joint, err); });
  }
  /** The text of a rig.json. */
  result<std::string> to_json() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_character_to_json(c(), id_, text, capacity, size, err);
    });
  }
  /** Writes rig.json, whole or not at all. */
  result<void> write(std::string_view path) const {
    return detail::perform([&](mry_error *err) { return mry_character_write(c(), id_, detail::str(path), err); });
  }
  /** Binds it, as it is now, to its skeleton. */
  result<marey::poser> poser(std::string_view deformer = {}, std::int32_t area = MRY_AREA_EXACT) const {
    return other<marey::poser, mry_poser>([&](mry_poser *id, mry_error *err) {
      return mry_poser_create(c(), id_, detail::str(deformer), area, id, err);
    });
  }
  /** Key poses for it, without a key. */
  result<marey::poses> new_poses(double fps = 24.0, std::uint32_t step = 1) const {
    return other<marey::poses, mry_poses>(
      [&](mry_poses *id, mry_error *err) { return mry_poses_create(c(), id_, fps, step, id, err); });
  }
  /** Reads key poses for it. */
  result<marey::poses> read_poses(std::string_view path) const {
    return other<marey::poses, mry_poses>(
      [&](mry_poses *id, mry_error *err) { return mry_poses_read(c(), id_, detail::str(path), id, err); });
  }
  /** A take of key poses. */
  result<take> play(const marey::poses &poses) const {
    mry_take_desc desc = MRY_TAKE_DESC_INIT;
    desc.poses = poses.id();
    return other<take, mry_take>([&](mry_take *id, mry_error *err) { return mry_run_take(c(), &desc, id, err); });
  }
  /** A take of a motion. */
  result<take> follow(const motion &motion, const carrying &how = {}) const {
    return how.with([&](const mry_retarget_desc *carried) {
      mry_take_desc desc = MRY_TAKE_DESC_INIT;
      desc.character = id_;
      desc.motion = motion.id();
      desc.retarget = carried;
      return other<take, mry_take>([&](mry_take *id, mry_error *err) { return mry_run_take(c(), &desc, id, err); });
    });
  }
  /** The motion of its joints that another motion leads to. */
  result<marey::motion> retarget(const motion &motion, const carrying &how = {}) const {
    return how.with([&](const mry_retarget_desc *carried) {
      return other<marey::motion, mry_motion>([&](mry_motion *id, mry_error *err) {
        return mry_motion_retarget(c(), motion.id(), id_, carried, id, err);
      });
    });
  }
  /** Which of its joints follows what of a motion, as the text of a map.json. */
  result<std::string> match(const motion &motion, const carrying &how = {}) const {
    return how.with([&](const mry_retarget_desc *carried) {
      return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
        return mry_motion_match(c(), motion.id(), id_, carried, text, capacity, size, err);
      });
    });
  }
};

/** A mesh bound to its handles. */
class deformation : public detail::handle<mry_deformation, mry_deformation_destroy> {
public:
  using handle::handle;

  /** Moves the mesh so that every handle is where the targets say, from `shape`, which is given the new places. */
  result<void> solve(const std::vector<mry_handle> &targets, std::vector<mry_point> &shape) {
    return detail::perform([&](mry_error *err) {
      return mry_deformation_solve(c(), id_, targets.data(), targets.size(), shape.data(), shape.data(), shape.size(),
                                   err);
    });
  }
};

/** A document that a host edits: a clip by reference, a rig, parameters, a motion. Its end keeps what was not saved. */
class session : public detail::handle<mry_session, mry_session_destroy> {
public:
  using handle::handle;

  /** How it is. */
  result<mry_session_state> state() const {
    mry_session_state state = MRY_SESSION_STATE_INIT;
    return detail::perform([&](mry_error *err) { return mry_session_get_state(c(), id_, &state, err); },
                           [&] { return state; });
  }
  /** Where it is kept. Fails with MRY_E_NOT_FOUND where that is memory. */
  result<std::string> path() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_session_get_path(c(), id_, text, capacity, size, err);
    });
  }
  /** One thing that opening it found damaged, lost or not there; `index` is below warning_count. */
  result<std::string> warning(std::uint32_t index) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_session_get_warning(c(), id_, index, text, capacity, size, err);
    });
  }
  /** Saves it to its file, whole or not at all. */
  result<void> save() {
    return detail::perform([&](mry_error *err) { return mry_session_save(c(), id_, err); });
  }
  /** Saves it under another name and goes on there. */
  result<void> save_as(std::string_view path) {
    return detail::perform([&](mry_error *err) { return mry_session_save_as(c(), id_, detail::str(path), err); });
  }
  /** Drops what was not saved. The session is then empty and has no file. */
  result<void> discard() {
    return detail::perform([&](mry_error *err) { return mry_session_discard(c(), id_, err); });
  }

  /** Begins a gesture: the edits until its end are one step of undo. */
  result<void> begin_gesture(std::string_view label) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_begin_gesture(c(), id_, detail::str(label), err); });
  }
  /** Ends the gesture; it is on the disk then. */
  result<void> end_gesture() {
    return detail::perform([&](mry_error *err) { return mry_session_end_gesture(c(), id_, err); });
  }
  /** Takes the gesture in progress back. */
  result<void> cancel_gesture() {
    return detail::perform([&](mry_error *err) { return mry_session_cancel_gesture(c(), id_, err); });
  }
  /** Takes the last step back. Fails with MRY_E_NOT_FOUND where there is none. */
  result<void> undo() {
    return detail::perform([&](mry_error *err) { return mry_session_undo(c(), id_, err); });
  }
  /** Does the last step that was taken back again. Fails with MRY_E_NOT_FOUND where there is none. */
  result<void> redo() {
    return detail::perform([&](mry_error *err) { return mry_session_redo(c(), id_, err); });
  }
  /** What undo() would take back. */
  result<std::string> undo_label() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_session_get_undo_label(c(), id_, text, capacity, size, err);
    });
  }
  /** What redo() would do again. */
  result<std::string> redo_label() const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_session_get_redo_label(c(), id_, text, capacity, size, err);
    });
  }

  /** Chooses the clip, by reference. */
  result<void> set_clip(const marey::clip &clip) {
    return detail::perform([&](mry_error *err) { return mry_session_set_clip(c(), id_, clip.id(), err); });
  }
  /** The clip, opened. */
  result<marey::clip> clip() const {
    return other<marey::clip, mry_clip>(
      [&](mry_clip *id, mry_error *err) { return mry_session_get_clip(c(), id_, nullptr, id, err); });
  }
  /** Lets saves put the clip and the painted masks into the file, or refer to them. */
  result<void> set_embedded(bool embedded) {
    return detail::perform([&](mry_error *err) { return mry_session_set_embedded(c(), id_, embedded ? 1 : 0, err); });
  }
  /** Begins a recording of its gestures in a file that does not exist. */
  result<void> start_recording(std::string_view path) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_start_recording(c(), id_, detail::str(path), err); });
  }
  /** Ends the recording. */
  result<void> stop_recording() {
    return detail::perform([&](mry_error *err) { return mry_session_stop_recording(c(), id_, err); });
  }
  /** A number that is the same for what is alike to the last bit, on any machine. */
  result<std::uint64_t> fingerprint() const {
    std::uint64_t number = 0;
    return detail::perform([&](mry_error *err) { return mry_session_get_fingerprint(c(), id_, &number, err); },
                           [&] { return number; });
  }
  /** Sets a part, MRY_PART_POINTS, ..., by the bytes of its file; none to take it away. */
  result<void> set_part(std::int32_t part, const std::vector<std::uint8_t> &bytes) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_set_part(c(), id_, part, bytes.data(), bytes.size(), err); });
  }
  /** A part, as the bytes of its file. */
  result<std::vector<std::uint8_t>> part(std::int32_t part) const {
    return detail::list<std::uint8_t>(
      [&](std::uint8_t *bytes, std::size_t capacity, std::size_t *count, mry_error *err) {
        return mry_session_get_part(c(), id_, part, bytes, capacity, count, err);
      });
  }
  /** Replaces everything that is drawn by a copy of a rig. */
  result<void> set_rig(const marey::rig &rig) {
    return detail::perform([&](mry_error *err) { return mry_session_set_rig(c(), id_, rig.id(), err); });
  }
  /** A copy of what is drawn. */
  result<marey::rig> rig() const {
    return other<marey::rig, mry_rig>(
      [&](mry_rig *id, mry_error *err) { return mry_session_get_rig(c(), id_, id, err); });
  }
  /** Takes in a motion as if it had been tracked from what is drawn now. */
  result<void> set_motion(const marey::motion &motion) {
    return detail::perform([&](mry_error *err) { return mry_session_set_motion(c(), id_, motion.id(), err); });
  }
  /** The motion, up to date or not. */
  result<marey::motion> motion() const {
    return other<marey::motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_session_get_motion(c(), id_, id, err); });
  }

  /** Adds a limb; gives its index. */
  result<std::uint32_t> add_limb(std::string_view label, std::int32_t side = MRY_SIDE_UNKNOWN) {
    std::uint32_t limb = 0;
    return detail::perform(
      [&](mry_error *err) { return mry_session_add_limb(c(), id_, detail::str(label), side, &limb, err); },
      [&] { return limb; });
  }
  /** Removes a limb with its strokes. */
  result<void> remove_limb(std::uint32_t limb) {
    return detail::perform([&](mry_error *err) { return mry_session_remove_limb(c(), id_, limb, err); });
  }
  /** Gives a limb another label and side. */
  result<void> set_limb(std::uint32_t limb, std::string_view label, std::int32_t side) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_set_limb(c(), id_, limb, detail::str(label), side, err); });
  }
  /** Says where a limb is in depth on a frame: MRY_SAID_DEPTH and MRY_SAID_BEND, or 0 to take it back. */
  result<void> set_depth(std::uint32_t limb, std::uint64_t frame, std::uint32_t said, float depth, float bend) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_set_depth(c(), id_, limb, frame, said, depth, bend, err); });
  }
  /** Draws a limb on a frame, instead of what was drawn of it there before. */
  result<void> set_stroke(std::uint32_t limb, std::uint64_t frame, const std::vector<mry_point> &points,
                          std::int32_t facing = MRY_FACING_UNKNOWN) {
    return detail::perform([&](mry_error *err) {
      return mry_session_set_stroke(c(), id_, limb, frame, points.data(), points.size(), facing, err);
    });
  }
  /** Takes a limb's stroke off a frame. */
  result<void> remove_stroke(std::uint32_t limb, std::uint64_t frame) {
    return detail::perform([&](mry_error *err) { return mry_session_remove_stroke(c(), id_, limb, frame, err); });
  }
  /** Paints a hint for the segmenter. */
  result<void> add_paint(std::uint64_t frame, std::int32_t kind, float radius, const std::vector<mry_point> &points) {
    return detail::perform([&](mry_error *err) {
      return mry_session_add_paint(c(), id_, frame, kind, radius, points.data(), points.size(), err);
    });
  }
  /** Removes one painted hint of a frame. */
  result<void> remove_paint(std::uint64_t frame, std::uint32_t index) {
    return detail::perform([&](mry_error *err) { return mry_session_remove_paint(c(), id_, frame, index, err); });
  }
  /** Gives the whole mask of a frame as an image file; empty to take it off. */
  result<void> set_mask(std::uint64_t frame, std::string_view path) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_set_mask(c(), id_, frame, detail::str(path), err); });
  }

  /** Chooses the value of a parameter. */
  result<void> set_parameter(std::string_view name, double value) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_set_parameter(c(), id_, detail::str(name), value, err); });
  }
  /** Chooses the text of a parameter, such as "track.plugin"; empty for the default. */
  result<void> set_text(std::string_view name, std::string_view text) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_set_text(c(), id_, detail::str(name), detail::str(text), err); });
  }
  /** The text of a parameter, chosen or by default. */
  result<std::string> text(std::string_view name) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_session_get_text(c(), id_, detail::str(name), text, capacity, size, err);
    });
  }
  /** Gives a parameter its default value again. */
  result<void> reset_parameter(std::string_view name) {
    return detail::perform(
      [&](mry_error *err) { return mry_session_reset_parameter(c(), id_, detail::str(name), err); });
  }
  /** The value of a parameter, chosen or by default. */
  result<double> parameter(std::string_view name) const {
    double value = 0.0;
    return detail::perform(
      [&](mry_error *err) { return mry_session_get_parameter(c(), id_, detail::str(name), &value, err); },
      [&] { return value; });
  }

  /** Starts tracking what is out of date of it as it is now. */
  result<job> start_track() const {
    return other<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_session_start_track(c(), id_, id, err); });
  }
  /** Starts making its creature as it is now, and writing it into a folder unless that is empty. */
  result<job> start_creature(std::string_view folder = {}) const {
    return other<job, mry_job>([&](mry_job *id, mry_error *err) {
      return mry_session_start_creature(c(), id_, detail::str(folder), id, err);
    });
  }
  /** Takes in what a job of this session made, as one step of undo; once. */
  result<void> take(const job &job) {
    return detail::perform([&](mry_error *err) { return mry_session_take(c(), id_, job.id(), err); });
  }
  /** Tracks what is out of date, takes the motion in, and returns when it is done. */
  result<void> run_track() {
    return detail::perform([&](mry_error *err) { return mry_session_run_track(c(), id_, err); });
  }
  /** Makes its creature, takes the motion in, and returns when it is done. */
  result<creature> run_creature(std::string_view folder = {}) {
    return other<creature, mry_creature>([&](mry_creature *id, mry_error *err) {
      return mry_session_run_creature(c(), id_, detail::str(folder), id, err);
    });
  }
  /** The frames in which a limb is to be tracked, for the first time or again. */
  result<std::vector<mry_frame_range>> outdated(std::uint32_t limb) const {
    return detail::list<mry_frame_range>(
      [&](mry_frame_range *ranges, std::size_t capacity, std::size_t *count, mry_error *err) {
        return mry_session_get_outdated(c(), id_, limb, ranges, capacity, count, err);
      });
  }
};

/** Which tracker and segmenter; empty names are the best there are. */
struct methods {
  /** The tracker: "space-time", "paper". */
  std::string_view tracker;
  /** The segmenter: "layered", "paper". */
  std::string_view segmenter;
  /** What covers a creature's limbs: MRY_SURFACE_SKIN, MRY_SURFACE_TUBES; 0 for what is usual. */
  std::uint32_t surface = 0;
};

/** How to create a context. */
struct context_options {
  /** Worker threads; 0 for one a core. */
  std::uint32_t threads = 0;
  /** Takes the log's lines, from several threads at a time. What it throws ends the program. */
  std::function<void(std::int32_t level, std::string_view line)> log;
  /** What the context will work on at most; zeros are the defaults. */
  mry_limits limits = MRY_LIMITS_INIT;
  /** Lends threads; where spawn is NULL the library starts its own. */
  mry_executor executor = MRY_EXECUTOR_INIT;
  /** Lends memory for decoded frames; where alloc is NULL it is the library's own. */
  mry_allocator allocator = MRY_ALLOCATOR_INIT;
};

/** The library's state for one user. Moves; lives as long as its last object. */
class context {
public:
#ifndef MAREY_NO_EXCEPTIONS
  /** Creates a context and starts its threads. */
  explicit context(context_options options = {}) : context(create(std::move(options))) {}
#endif
  context(context &&) noexcept = default;
  context &operator=(context &&) noexcept = default;

  /** Creates a context and starts its threads. */
  static result<context> create(context_options options = {}) {
    auto state = std::make_shared<detail::state>();
    mry_context_desc desc = MRY_CONTEXT_DESC_INIT;
    desc.threads = options.threads;
    desc.limits = &options.limits;
    desc.executor = options.executor.spawn != nullptr ? &options.executor : nullptr;
    desc.allocator = options.allocator.alloc != nullptr ? &options.allocator : nullptr;
    if (options.log) {
      state->log = std::move(options.log);
      desc.log = detail::state::take_line;
      desc.log_user = state.get();
    }
    return detail::perform([&](mry_error *err) { return mry_context_create(&desc, &state->context, err); },
                           [&] { return context(std::move(state)); });
  }

  /** For calls of marey.h. It stays this context's. */
  mry_context *get() const noexcept { return state_ ? state_->context : nullptr; }

  /** How many worker threads it has. */
  result<std::uint32_t> threads() const {
    std::uint32_t threads = 0;
    return detail::perform([&](mry_error *err) { return mry_context_get_threads(get(), &threads, err); },
                           [&] { return threads; });
  }
  /** Opens a video file or a folder of numbered images. */
  result<clip> open(std::string_view path, const mry_clip_options *options = nullptr) const {
    return make<clip, mry_clip>([&](mry_clip *id, mry_error *err) {
      return mry_clip_open(get(), detail::str(path), options, id, err);
    });
  }
  /** Opens a creature.glb, one that a modelling program wrote of it, or a creature's folder. */
  result<creature> open_creature(std::string_view path) const {
    return make<creature, mry_creature>([&](mry_creature *id, mry_error *err) {
      return mry_creature_open(get(), detail::str(path), id, err);
    });
  }
  /** A crowd of these instances, with as many frames as the longest creature where none are said. */
  result<crowd> new_crowd(const std::vector<mry_instance> &instances, std::uint64_t frames = 0, double fps = 0.0) const {
    return make<crowd, mry_crowd>([&](mry_crowd *id, mry_error *err) {
      return mry_crowd_create(get(), instances.data(), instances.size(), frames, fps, id, err);
    });
  }
  /** A creature many times over in rows, out of step. */
  result<crowd> new_herd(const creature &of, std::uint32_t count, std::uint64_t frames = 0) const {
    return make<crowd, mry_crowd>([&](mry_crowd *id, mry_error *err) {
      return mry_crowd_create_herd(get(), of.id(), count, frames, id, err);
    });
  }
  /** Reads a crowd and opens its creatures. */
  result<crowd> read_crowd(std::string_view path) const {
    return make<crowd, mry_crowd>(
      [&](mry_crowd *id, mry_error *err) { return mry_crowd_read(get(), detail::str(path), id, err); });
  }
  /** An empty rig for a clip of this size. */
  result<rig> new_rig(std::uint32_t width, std::uint32_t height) const {
    return make<rig, mry_rig>(
      [&](mry_rig *id, mry_error *err) { return mry_rig_create(get(), width, height, id, err); });
  }
  /** Reads a strokes.json file. */
  result<rig> read_rig(std::string_view path) const {
    return make<rig, mry_rig>(
      [&](mry_rig *id, mry_error *err) { return mry_rig_read(get(), detail::str(path), id, err); });
  }
  /** Reads the text of a strokes.json. */
  result<rig> rig_from_json(std::string_view json) const {
    return make<rig, mry_rig>(
      [&](mry_rig *id, mry_error *err) { return mry_rig_from_json(get(), detail::str(json), id, err); });
  }
  /** Joints of which none is marked, for a clip of this size. */
  result<joints> new_joints(std::uint32_t width, std::uint32_t height) const {
    return make<joints, mry_joints>(
      [&](mry_joints *id, mry_error *err) { return mry_joints_create(get(), width, height, id, err); });
  }
  /** Reads a joints.json file. */
  result<joints> read_joints(std::string_view path) const {
    return make<joints, mry_joints>(
      [&](mry_joints *id, mry_error *err) { return mry_joints_read(get(), detail::str(path), id, err); });
  }
  /** Reads the text of a joints.json. */
  result<joints> joints_from_json(std::string_view json) const {
    return make<joints, mry_joints>(
      [&](mry_joints *id, mry_error *err) { return mry_joints_from_json(get(), detail::str(json), id, err); });
  }
  /** Control points of which none is marked, for a clip of this size. */
  result<control_points> new_control_points(std::uint32_t width, std::uint32_t height) const {
    return make<control_points, mry_control_points>([&](mry_control_points *id, mry_error *err) {
      return mry_control_points_create(get(), width, height, id, err);
    });
  }
  /** Reads a points.json file. */
  result<control_points> read_control_points(std::string_view path) const {
    return make<control_points, mry_control_points>([&](mry_control_points *id, mry_error *err) {
      return mry_control_points_read(get(), detail::str(path), id, err);
    });
  }
  /** Reads the text of a points.json. */
  result<control_points> control_points_from_json(std::string_view json) const {
    return make<control_points, mry_control_points>([&](mry_control_points *id, mry_error *err) {
      return mry_control_points_from_json(get(), detail::str(json), id, err);
    });
  }
  /** Reads an SVG file. */
  result<drawing> read_svg(std::string_view path) const {
    return make<drawing, mry_drawing>(
      [&](mry_drawing *id, mry_error *err) { return mry_drawing_read_svg(get(), detail::str(path), id, err); });
  }
  /** Reads the text of an SVG file. */
  result<drawing> drawing_from_svg(std::string_view svg) const {
    return make<drawing, mry_drawing>(
      [&](mry_drawing *id, mry_error *err) { return mry_drawing_from_svg(get(), detail::str(svg), id, err); });
  }
  /** A drawing without strokes, on a page of this size. */
  result<drawing> new_drawing(double width, double height) const {
    return make<drawing, mry_drawing>(
      [&](mry_drawing *id, mry_error *err) { return mry_drawing_create(get(), width, height, id, err); });
  }
  /** A binding of a drawing by which nothing is held yet. */
  result<binding> new_binding(const drawing &drawing) const {
    return make<binding, mry_binding>(
      [&](mry_binding *id, mry_error *err) { return mry_binding_create(get(), drawing.id(), id, err); });
  }
  /** Reads a bind.json file. */
  result<binding> read_binding(std::string_view path) const {
    return make<binding, mry_binding>(
      [&](mry_binding *id, mry_error *err) { return mry_binding_read(get(), detail::str(path), id, err); });
  }
  /** Reads the text of a bind.json. */
  result<binding> binding_from_json(std::string_view json) const {
    return make<binding, mry_binding>(
      [&](mry_binding *id, mry_error *err) { return mry_binding_from_json(get(), detail::str(json), id, err); });
  }
  /** Makes a motion of the text of a paths.json: points that run along drawn paths. */
  result<motion> motion_from_paths(std::string_view json) const {
    return make<motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_motion_from_paths(get(), detail::str(json), id, err); });
  }
  /** Reads a motion.json file. */
  result<motion> read_motion(std::string_view path) const {
    return make<motion, mry_motion>(
      [&](mry_motion *id, mry_error *err) { return mry_motion_read(get(), detail::str(path), id, err); });
  }
  /** A motion without tracks, for a clip of this size. */
  result<motion> new_motion(std::uint32_t width, std::uint32_t height, std::uint64_t frames, double fps) const {
    return make<motion, mry_motion>([&](mry_motion *id, mry_error *err) {
      return mry_motion_create(get(), width, height, frames, fps, id, err);
    });
  }
  /** Starts opening a clip. */
  result<job> start_open(std::string_view path, const mry_clip_options *options = nullptr) const {
    return make<job, mry_job>([&](mry_job *id, mry_error *err) {
      return mry_job_start_open(get(), detail::str(path), options, id, err);
    });
  }
  /** Starts tracking. */
  result<job> start_track(const clip &clip, const rig &rig, const methods &by = {}) const {
    mry_track_desc desc = MRY_TRACK_DESC_INIT;
    desc.clip = clip.id();
    desc.rig = rig.id();
    desc.tracker = detail::str(by.tracker);
    return make<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_job_start_track(get(), &desc, id, err); });
  }
  /** Starts tracking again what differs between a rig and the one that an earlier motion was tracked from. */
  result<job> start_retrack(const clip &clip, const rig &rig, const motion &earlier, const marey::rig &earlier_rig,
                            const methods &by = {}) const {
    mry_track_desc desc = MRY_TRACK_DESC_INIT;
    desc.clip = clip.id();
    desc.rig = rig.id();
    desc.tracker = detail::str(by.tracker);
    desc.earlier = earlier.id();
    desc.earlier_rig = earlier_rig.id();
    return make<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_job_start_track(get(), &desc, id, err); });
  }
  /** Starts capture: joints marked on one frame, followed through the clip. */
  result<job> start_capture(const clip &clip, const joints &joints) const {
    mry_capture_desc desc = MRY_CAPTURE_DESC_INIT;
    desc.clip = clip.id();
    desc.joints = joints.id();
    return make<job, mry_job>(
      [&](mry_job *id, mry_error *err) { return mry_job_start_capture(get(), &desc, id, err); });
  }
  /** Starts capturing again what differs between joints and those that an earlier motion was captured from. */
  result<job> start_recapture(const clip &clip, const joints &joints, const motion &earlier,
                              const marey::joints &earlier_joints) const {
    mry_capture_desc desc = MRY_CAPTURE_DESC_INIT;
    desc.clip = clip.id();
    desc.joints = joints.id();
    desc.earlier = earlier.id();
    desc.earlier_joints = earlier_joints.id();
    return make<job, mry_job>(
      [&](mry_job *id, mry_error *err) { return mry_job_start_capture(get(), &desc, id, err); });
  }
  /** Starts looking for points to follow on a frame of the clip, counted from 1, or 0 for the one of a few that shows most
   *  ends; `most` at most, 0 for 12. */
  result<job> start_propose_points(const clip &clip, std::uint64_t frame_from_one = 0, std::uint32_t most = 0) const {
    return make<job, mry_job>([&](mry_job *id, mry_error *err) {
      return mry_job_start_propose_points(get(), clip.id(), frame_from_one, most, id, err);
    });
  }
  /** Starts tracking control points through the clip. With `keep`, what was read and solved stays in memory until the clip is
   *  closed, and the next time only what differs is solved. */
  result<job> start_point_track(const clip &clip, const control_points &points, bool keep = false) const {
    mry_point_track_desc desc = MRY_POINT_TRACK_DESC_INIT;
    desc.clip = clip.id();
    desc.points = points.id();
    desc.keep = keep ? 1u : 0u;
    return make<job, mry_job>(
      [&](mry_job *id, mry_error *err) { return mry_job_start_point_track(get(), &desc, id, err); });
  }
  /** Starts laying what moves on a drawing; drawing and motion of the description must be set. */
  result<job> start_bind(const mry_bind_desc &desc) const {
    return make<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_job_start_bind(get(), &desc, id, err); });
  }
  /** Starts moving a drawing by motions, in the binding's order. */
  result<job> start_sketch_take(const drawing &drawing, const binding &binding,
                                const std::vector<mry_motion> &motions) const {
    mry_sketch_take_desc desc = MRY_SKETCH_TAKE_DESC_INIT;
    desc.drawing = drawing.id();
    desc.binding = binding.id();
    desc.motions = motions.data();
    desc.motion_count = motions.size();
    return make<job, mry_job>(
      [&](mry_job *id, mry_error *err) { return mry_job_start_sketch_take(get(), &desc, id, err); });
  }
  /** Starts writing a drawing in motion; take and path of the description must be set. */
  result<job> start_sketch_file(const mry_sketch_file_desc &desc) const {
    return make<job, mry_job>(
      [&](mry_job *id, mry_error *err) { return mry_job_start_sketch_file(get(), &desc, id, err); });
  }
  /** Starts segmenting, after tracking where no motion is given. */
  result<job> start_segment(const clip &clip, const rig &rig, const motion *tracked = nullptr,
                            const methods &by = {}) const {
    mry_segment_desc desc = MRY_SEGMENT_DESC_INIT;
    desc.clip = clip.id();
    desc.rig = rig.id();
    desc.motion = tracked != nullptr ? tracked->id() : mry_motion{};
    desc.tracker = detail::str(by.tracker);
    desc.segmenter = detail::str(by.segmenter);
    return make<job, mry_job>(
      [&](mry_job *id, mry_error *err) { return mry_job_start_segment(get(), &desc, id, err); });
  }
  /** Starts the whole job. */
  result<job> start_creature(const clip &clip, const rig &rig, const methods &by = {}) const {
    const mry_creature_desc desc = creature_desc(clip, rig, by);
    return make<job, mry_job>(
      [&](mry_job *id, mry_error *err) { return mry_job_start_creature(get(), &desc, id, err); });
  }
  /** Makes a creature, and returns when it is done. */
  result<creature> run_creature(const clip &clip, const rig &rig, const methods &by = {}) const {
    const mry_creature_desc desc = creature_desc(clip, rig, by);
    return make<creature, mry_creature>(
      [&](mry_creature *id, mry_error *err) { return mry_run_creature(get(), &desc, id, err); });
  }
  /** Starts writing a creature's files: MRY_EXPORT_GLB, ... */
  result<job> start_export(const creature &creature, std::int32_t what, std::string_view path) const {
    mry_export_desc desc = MRY_EXPORT_DESC_INIT;
    desc.what = what;
    desc.creature = creature.id();
    desc.path = detail::str(path);
    return make<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_job_start_export(get(), &desc, id, err); });
  }
  /** Starts drawing a creature into a file. */
  result<job> start_render(const mry_render_file_desc &desc) const {
    return make<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_job_start_render(get(), &desc, id, err); });
  }
  /** Who draws: MRY_ADAPTER_AUTO, ... */
  result<std::string> renderer(std::int32_t adapter) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_context_get_renderer(get(), adapter, text, capacity, size, err);
    });
  }
  /** Starts making a solid for printing; creature of the description must be set. */
  result<job> start_print(const mry_print_desc &desc) const {
    return make<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_job_start_print(get(), &desc, id, err); });
  }
  /** Makes a solid for printing, and returns when it is done; creature of the description must be set. */
  result<solid> run_print(const mry_print_desc &desc) const {
    return make<solid, mry_solid>([&](mry_solid *id, mry_error *err) { return mry_run_print(get(), &desc, id, err); });
  }
  /** Starts giving a creature other textures; the job makes a creature. */
  result<job> start_texture(const mry_texture_desc &desc) const {
    return make<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_job_start_texture(get(), &desc, id, err); });
  }
  /** Gives a creature other textures, and returns when it is done. */
  result<creature> run_texture(const mry_texture_desc &desc) const {
    return make<creature, mry_creature>(
      [&](mry_creature *id, mry_error *err) { return mry_run_texture(get(), &desc, id, err); });
  }
  /** Starts taking an edited mesh into a creature; the job makes a creature. */
  result<job> start_edit(const mry_edit_desc &desc) const {
    return make<job, mry_job>([&](mry_job *id, mry_error *err) { return mry_job_start_edit(get(), &desc, id, err); });
  }
  /** Takes an edited mesh into a creature, and returns when it is done. */
  result<creature> run_edit(const mry_edit_desc &desc) const {
    return make<creature, mry_creature>(
      [&](mry_creature *id, mry_error *err) { return mry_run_edit(get(), &desc, id, err); });
  }
  /** An empty session in a new file, or in memory only where the path is empty. */
  result<session> new_session(std::string_view path = {}) const {
    return make<session, mry_session>(
      [&](mry_session *id, mry_error *err) { return mry_session_create(get(), detail::str(path), id, err); });
  }
  /** An empty session that the user has not named yet, kept in a folder so that a crash does not lose it. */
  result<session> new_untitled_session(std::string_view folder) const {
    return make<session, mry_session>([&](mry_session *id, mry_error *err) {
      return mry_session_create_untitled(get(), detail::str(folder), id, err);
    });
  }
  /** One of the sessions without a name that a crash left in a folder. Fails with MRY_E_NOT_FOUND after the last. */
  result<std::string> left_session(std::string_view folder, std::uint32_t index) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_session_find_left(get(), detail::str(folder), index, text, capacity, size, err);
    });
  }
  /** Opens a session file: MRY_ACCESS_EDIT, ... */
  result<session> open_session(std::string_view path, std::int32_t access = MRY_ACCESS_EDIT) const {
    return make<session, mry_session>([&](mry_session *id, mry_error *err) {
      return mry_session_open(get(), detail::str(path), access, id, err);
    });
  }
  /** Plays the first `most` gestures of a recording; the session that they lead to is kept in memory only. */
  result<session> replay(std::string_view path, std::uint64_t most = UINT64_MAX) const {
    return make<session, mry_session>([&](mry_session *id, mry_error *err) {
      return mry_session_replay(get(), detail::str(path), most, id, err);
    });
  }
  /** Makes a character. Start from MRY_CHARACTER_DESC_INIT. */
  result<character> run_character(const mry_character_desc &desc) const {
    return make<character, mry_character>(
      [&](mry_character *id, mry_error *err) { return mry_run_character(get(), &desc, id, err); });
  }
  /** Makes a character of a drawing, with a mesh and a skeleton that are proposed. */
  result<character> draw(std::string_view picture) const {
    mry_character_desc desc = MRY_CHARACTER_DESC_INIT;
    desc.picture = detail::str(picture);
    return run_character(desc);
  }
  /** Reads a BVH file: MRY_VIEW_FRONT, ... */
  result<motion> read_bvh(std::string_view path, std::int32_t view = MRY_VIEW_FRONT) const {
    return make<motion, mry_motion>([&](mry_motion *id, mry_error *err) {
      return mry_motion_read_bvh(get(), detail::str(path), view, 0, id, err);
    });
  }
  /** Binds a mesh to handles. Start from MRY_DEFORM_DESC_INIT. */
  result<deformation> bind(const mry_deform_desc &desc) const {
    return make<deformation, mry_deformation>(
      [&](mry_deformation *id, mry_error *err) { return mry_deformation_create(get(), &desc, id, err); });
  }
  /** Opens the registry of plugins; once. Start from MRY_PLUGINS_DESC_INIT. */
  result<void> open_plugins(const mry_plugins_desc &desc) const {
    return detail::perform([&](mry_error *err) { return mry_plugins_open(get(), &desc, err); });
  }
  /** Loads what is new in the plugin folders, and new builds; gives how many files changed. */
  result<std::uint32_t> rescan_plugins() const {
    std::uint32_t changes = 0;
    return detail::perform([&](mry_error *err) { return mry_plugins_rescan(get(), &changes, err); },
                           [&] { return changes; });
  }
  /** Loads one plugin library or bundle. */
  result<void> load_plugin(std::string_view file) const {
    return detail::perform([&](mry_error *err) { return mry_plugins_load(get(), detail::str(file), err); });
  }
  /** One of the plugins that are loaded. Fails with MRY_E_NOT_FOUND after the last. */
  result<mry_plugin_info> plugin(std::uint32_t index) const {
    mry_plugin_info info = MRY_PLUGIN_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_plugin_get_info(get(), index, &info, err); },
                           [&] { return info; });
  }
  /** Why one of the files that are no plugins was not loaded. Fails with MRY_E_NOT_FOUND after the last. */
  result<std::string> plugin_failure(std::uint32_t index) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      mry_status status = MRY_OK;
      return mry_plugin_get_failure(get(), index, &status, text, capacity, size, err);
    });
  }
  /** One of a plugin's parameters. Fails with MRY_E_NOT_FOUND after the last. */
  result<mry_plugin_parameter_info> plugin_parameter(std::string_view id, std::uint32_t index) const {
    mry_plugin_parameter_info info = MRY_PLUGIN_PARAMETER_INFO_INIT;
    return detail::perform(
      [&](mry_error *err) { return mry_plugin_get_parameter(get(), detail::str(id), index, &info, err); },
      [&] { return info; });
  }
  /** Chooses the value of a plugin's parameter. */
  result<void> set_plugin_number(std::string_view id, std::string_view name, double value) const {
    return detail::perform([&](mry_error *err) {
      return mry_plugin_set_number(get(), detail::str(id), detail::str(name), value, err);
    });
  }
  /** Switches a plugin off, or on again. */
  result<void> enable_plugin(std::string_view id, bool enabled) const {
    return detail::perform(
      [&](mry_error *err) { return mry_plugin_set_enabled(get(), detail::str(id), enabled ? 1 : 0, err); });
  }
  /** One of the parameters of sessions. Fails with MRY_E_NOT_FOUND after the last. */
  result<mry_parameter_info> parameter(std::uint32_t index) const {
    mry_parameter_info info = MRY_PARAMETER_INFO_INIT;
    return detail::perform([&](mry_error *err) { return mry_parameter_get_info(get(), index, &info, err); },
                           [&] { return info; });
  }
  /** The name of one of the values of a choice. */
  result<std::string> parameter_choice(std::uint32_t index, std::uint32_t choice) const {
    return detail::text([&](char *text, std::size_t capacity, std::size_t *size, mry_error *err) {
      return mry_parameter_get_choice(get(), index, choice, text, capacity, size, err);
    });
  }

private:
  explicit context(std::shared_ptr<detail::state> state) noexcept : state_(std::move(state)) {}

  static mry_creature_desc creature_desc(const clip &clip, const rig &rig, const methods &by) noexcept {
    mry_creature_desc desc = MRY_CREATURE_DESC_INIT;
    desc.clip = clip.id();
    desc.rig = rig.id();
    desc.tracker = detail::str(by.tracker);
    desc.segmenter = detail::str(by.segmenter);
    desc.surface = by.surface;
    return desc;
  }

  template <class Handle, class Id, class Call> result<Handle> make(Call call) const {
    Id id{};
    return detail::perform([&](mry_error *err) { return call(&id, err); }, [&] { return Handle(state_, id); });
  }

  std::shared_ptr<detail::state> state_;
};

} // namespace marey

#endif
