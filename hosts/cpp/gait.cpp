/*
 * gait.cpp: how an animal walks, measured from a video through marey.hpp.
 *
 *   gait CLIP STROKES.json OUT.csv
 *
 * Tracks the drawn limbs as a job whose progress is shown, writes the angle of every limb in every frame as a table,
 * and says how long a stride takes: the shift at which the swing of the limbs is most like itself (autocorrelation).
 * Ctrl-C cancels, and leaves no table behind.
 *
 *   c++ -std=c++17 gait.cpp $(pkg-config --cflags --libs marey) -o gait
 */
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <marey/marey.hpp>

namespace {

volatile std::sig_atomic_t interrupted = 0;

/* A limb's direction from its start to its end, in degrees, in every frame. */
struct swing {
  std::string limb;
  std::vector<double> angle;
  std::vector<double> confidence;
};

/* Runs the job to its end, a line for every ten percent. */
marey::motion watch(marey::job job) {
  int told = -1;
  while (!job.wait_for(std::chrono::milliseconds(50))) {
    if (interrupted != 0) {
      job.cancel();
    }
    const mry_job_state now = job.poll();
    const int tenths = static_cast<int>(now.fraction * 10.0);
    if (tenths > told) {
      told = tenths;
      std::printf("%3d%% %s\n", 10 * tenths, now.stage);
      std::fflush(stdout);
    }
  }
  return job.take_motion();
}

/* The angles of one track; they go on over 180 degrees instead of jumping. */
swing measure(const marey::motion &motion, const mry_motion_info &info, std::uint32_t track) {
  constexpr double turn = 360.0;
  swing found{ motion.track_name(track), {}, {} };
  for (std::uint64_t f = 0; f < info.frame_count; f++) {
    const marey::track_frame at = motion.frame(track, f);
    const mry_point from = at.points.front();
    const mry_point to = at.points.back();
    double angle = std::atan2(double{ to.y } - double{ from.y }, double{ to.x } - double{ from.x }) * turn / 6.283185307179586;
    if (!found.angle.empty()) {
      angle += turn * std::round((found.angle.back() - angle) / turn);
    }
    double trust = 0.0;
    for (const float c : at.confidence) {
      trust += double{ c } / static_cast<double>(at.confidence.size());
    }
    found.angle.push_back(angle);
    found.confidence.push_back(trust);
  }
  return found;
}

/* How alike the limbs' swings are when shifted by `lag` frames, in -1..1, limbs that swing more counting for more. */
double likeness(const std::vector<swing> &swings, std::size_t lag) {
  double product = 0.0;
  double energy = 0.0;
  for (const swing &s : swings) {
    double mean = 0.0;
    for (const double a : s.angle) {
      mean += a / static_cast<double>(s.angle.size());
    }
    for (std::size_t i = 0; i + lag < s.angle.size(); i++) {
      const double a = s.angle[i] - mean;
      const double b = s.angle[i + lag] - mean;
      product += a * b;
      energy += (a * a + b * b) / 2.0;
    }
  }
  return energy > 0.0 ? product / energy : 0.0;
}

/* The frames of a stride: the best shift behind the first at which the limbs swing against themselves. 0 when the clip
   is too short to show one. */
std::size_t stride(const std::vector<swing> &swings, std::size_t frames) {
  std::size_t lag = 1;
  while (lag < frames / 2 && likeness(swings, lag) > 0.0) {
    lag++;
  }
  std::size_t best = 0;
  for (double most = 0.2; lag <= frames / 2; lag++) {
    const double alike = likeness(swings, lag);
    if (alike > most) {
      most = alike;
      best = lag;
    }
  }
  return best;
}

bool write_table(const std::string &path, const std::vector<swing> &swings, double fps) {
  const std::string aside = path + ".part";
  std::ofstream out(aside);
  out << "seconds";
  for (const swing &s : swings) {
    out << ',' << s.limb << " degrees," << s.limb << " confidence";
  }
  out << '\n';
  for (std::size_t f = 0; f < swings.front().angle.size(); f++) {
    out << static_cast<double>(f) / fps;
    for (const swing &s : swings) {
      out << ',' << s.angle[f] << ',' << s.confidence[f];
    }
    out << '\n';
  }
  out.close();
  return out.good() && std::rename(aside.c_str(), path.c_str()) == 0;
}

int run(const char *path, const char *strokes, const std::string &table) {
  marey::context_options options;
  options.log = [](std::int32_t level, std::string_view line) {
    if (level != MRY_LOG_INFO) {
      std::fprintf(stderr, "marey: %.*s\n", static_cast<int>(line.size()), line.data());
    }
  };
  const marey::context context(std::move(options));
  const marey::clip clip = context.open(path);
  const marey::rig rig = context.read_rig(strokes);
  rig.validate(clip);
  const marey::motion motion = watch(context.start_track(clip, rig));
  const mry_motion_info info = motion.info();
  std::vector<swing> swings;
  for (std::uint32_t track = 0; track < info.track_count; track++) {
    swings.push_back(measure(motion, info, track));
  }
  if (!write_table(table, swings, info.fps)) {
    std::fprintf(stderr, "gait: cannot write %s\n", table.c_str());
    return 4;
  }
  std::printf("%zu limbs in %llu frames: %s\n", swings.size(), static_cast<unsigned long long>(info.frame_count),
              table.c_str());
  const std::size_t frames = stride(swings, static_cast<std::size_t>(info.frame_count));
  if (frames > 0) {
    std::printf("a stride takes %zu frames, %.2f seconds\n", frames, static_cast<double>(frames) / info.fps);
  } else {
    std::puts("the clip is too short to show a stride");
  }
  for (const mry_correction &next : motion.corrections(rig, 1)) {
    std::printf("least certain: %s on frame %llu\n", motion.track_name(next.track).c_str(),
                static_cast<unsigned long long>(next.frame));
  }
  return 0;
}

} // namespace

int main(int argc, char **argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s CLIP STROKES.json OUT.csv\n", argv[0]);
    return 2;
  }
  std::signal(SIGINT, [](int) { interrupted = 1; });
  try {
    return run(argv[1], argv[2], argv[3]);
  } catch (const marey::error &error) {
    std::fprintf(stderr, "gait: %s\n", error.what());
    return error.status() == MRY_CANCELLED ? 130 : 4;
  }
}
