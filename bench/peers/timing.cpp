// SPDX-License-Identifier: Apache-2.0
#include "timing.hpp"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "errors.hpp"
#include "fransac/io/overlay.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "statistics.hpp"

namespace fransac::bench {
namespace {

/// Runs that are longer start with whatever caches the others left: it is little of their time.
constexpr double kWarmBelow_ms = 20.0;

struct Timed {
  bool found = false;
  double ms = 0.0;
};

double now_ms(bool cpu_time) {
  if (!cpu_time) return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

Timed run_timed(Peer& peer, const Frame& frame, Answer& answer, bool cpu_time) {
  const double start = now_ms(cpu_time);
  const bool found = peer.run(frame, answer);
  return {found, now_ms(cpu_time) - start};
}

/// A contestant on its way through a suite.
struct Runner {
  Contestant contestant;
  std::size_t last_points = 0;  ///< Of the last scene, and its first run there.
  double last_ms = 0.0;
  double f1_sum = 0.0;
  int f1_count = 0;
};

Row new_row(const std::string& suite, const Scene& scene, const Contestant& contestant) {
  Row row;
  row.suite = suite;
  row.entry = contestant.entry;
  row.threads = contestant.threads;
  row.dataset = scene.dataset;
  row.scene = scene.name;
  row.width = scene.camera.width;
  row.height = scene.camera.height;
  row.points = scene.depth.empty()
                   ? scene.points.size() / 3
                   : scene.depth.size() - static_cast<std::size_t>(std::count(scene.depth.begin(), scene.depth.end(), 0));
  return row;
}

void draw(const Scene& scene, const Row& row, std::span<const std::uint8_t> labels, const std::filesystem::path& folder) {
  const DepthView view = DepthView::from_uint16(scene.depth.data(), row.width, row.height, scene.camera.depth_scale);
  const auto file = folder / fmt::format("{}_{}_{}.png", row.dataset, row.scene, row.entry->id);
  cli::check(io::write_png(file, io::overlay(view, labels, nullptr)));
}

void judge_objects(const Scene& scene, std::span<const std::uint16_t> objects, Row& row) {
  row.objects = cli::unwrap(eval::object_metrics(scene.objects, objects, std::span(scene.depth)));
}

void judge(const Scene& scene, const Answer& answer, const TimingOptions& options, Row& row, Runner& runner) {
  row.planes = answer.planes;
  row.inliers = answer.inliers;
  row.leaves = answer.leaves;
  if (answer.objects != nullptr && !scene.objects.empty()) {
    judge_objects(scene, std::span(answer.objects, scene.objects.size()), row);
  }
  if (row.entry->task != Task::segment || answer.labels == nullptr) return;
  const std::span labels(answer.labels, scene.frame().size());
  if (!options.overlays.empty() && !scene.depth.empty()) draw(scene, row, labels, options.overlays);
  if (scene.truth.empty()) return;
  row.dominant = cli::unwrap(eval::dominant_plane(scene.truth, labels));
  row.best_f1 = cli::unwrap(eval::best_overlap(scene.truth, labels)).detection.f1();
  if (scene.all_planes) {
    row.matched_f1 = cli::unwrap(eval::matched_plane(scene.truth, labels)).detection.f1();
    if (row.entry->method == kAllPlanes) row.instances = cli::unwrap(eval::instance_metrics(scene.truth, labels));
  }
  runner.f1_sum += *row.best_f1;
  ++runner.f1_count;
}

/// Who finds nothing is as wrong as can be.
void judge_nothing(const Scene& scene, Row& row, Runner& runner) {
  if (row.entry->task != Task::objects) {
    runner.f1_count += scene.truth.empty() ? 0 : 1;
  } else if (!scene.objects.empty()) {
    judge_objects(scene, std::vector<std::uint16_t>(scene.objects.size(), 0), row);
  }
}

/// The first answer of everybody; a row with a note will not be timed.
void answer_once(const Scene& scene, const TimingOptions& options, Runner& runner, Row& row) {
  const double limit_ms = 1e3 * options.max_seconds_per_run;
  const double growth = runner.last_points == 0 ? 1.0 : static_cast<double>(row.points) / static_cast<double>(runner.last_points);
  if (runner.last_ms * growth > limit_ms) {
    row.note = fmt::format("skipped: about {:.1f} s a run", runner.last_ms * growth / 1e3);
    return;
  }
  const Frame frame = scene.frame();
  Answer answer;
  runner.contestant.peer->load(frame);
  const Timed timed = run_timed(*runner.contestant.peer, frame, answer, options.cpu_time);
  runner.last_ms = timed.ms;
  runner.last_points = row.points;
  if (timed.found) {
    judge(scene, answer, options, row, runner);
  } else {
    row.note = "found nothing";
    judge_nothing(scene, row, runner);
  }
  if (timed.ms > limit_ms) row.note = fmt::format("not timed: {:.1f} s a run", timed.ms / 1e3);
}

void time_row(const Scene& scene, std::span<Row*> rows, std::span<Runner*> runners, const TimingOptions& options) {
  const Frame frame = scene.frame();
  std::vector<Answer> answers(rows.size());
  std::vector<double> spent_ms(rows.size(), 0.0);
  std::vector<std::map<std::string_view, std::vector<double>>> stages(rows.size());
  for (Runner* runner : runners) runner->contestant.peer->load(frame);
  for (int r = 0; r < options.repeat; ++r) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (spent_ms[i] > 1e3 * options.max_seconds_per_row) continue;
      Peer& peer = *runners[i]->contestant.peer;
      const bool warm_up = rows[i]->times_ms.empty() || rows[i]->times_ms.back() < kWarmBelow_ms;
      if (warm_up) spent_ms[i] += run_timed(peer, frame, answers[i], options.cpu_time).ms;
      const Timed timed = run_timed(peer, frame, answers[i], options.cpu_time);
      spent_ms[i] += timed.ms;
      rows[i]->times_ms.push_back(timed.ms);
      for (const auto& [stage, ms] : answers[i].stages) stages[i][stage].push_back(ms);
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const auto& [stage, last] : answers[i].stages) rows[i]->stages_ms.emplace_back(stage, cli::median(stages[i][stage]));
    const std::size_t times = rows[i]->times_ms.size();
    if (times < static_cast<std::size_t>(options.repeat)) {
      rows[i]->note = fmt::format("{} runs: {} s a row are enough", times, options.max_seconds_per_row);
    }
  }
}

}  // namespace

std::vector<Row> time_suite(const std::string& suite, std::span<const Scene> scenes, std::span<const Contestant> contestants,
                            const TimingOptions& options) {
  std::vector<Row> rows;
  std::vector<Runner> runners;
  for (const Contestant& contestant : contestants) {
    if (contestant.peer != nullptr) {
      runners.emplace_back().contestant = contestant;
    } else {
      Row& row = rows.emplace_back();
      row.suite = suite;
      row.entry = contestant.entry;
      row.threads = contestant.threads;
      row.note = "not built: its library was not found";
    }
  }
  const std::size_t first = rows.size();
  cli::Progress progress(2 * scenes.size());
  for (const Scene& scene : scenes) {
    progress.step(fmt::format("{}: checking {}/{}", suite, scene.dataset, scene.name));
    for (Runner& runner : runners)
      answer_once(scene, options, runner, rows.emplace_back(new_row(suite, scene, runner.contestant)));
  }
  const bool known = std::all_of(scenes.begin(), scenes.end(), [](const Scene& scene) { return scene.dominant; });
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    progress.step(fmt::format("{}: timing {}/{}", suite, scenes[s].dataset, scenes[s].name));
    std::vector<Row*> timed_rows;
    std::vector<Runner*> timed_runners;
    for (std::size_t i = 0; i < runners.size(); ++i) {
      Row& row = rows[first + s * runners.size() + i];
      double mean_f1 = runners[i].f1_count == 0 ? 1.0 : runners[i].f1_sum / runners[i].f1_count;
      if (options.scenes_stand_alone && row.best_f1) mean_f1 = *row.best_f1;
      if (known && mean_f1 < kSaneF1) row.note = fmt::format("not timed: failed its check, F1 {:.3f} < {}", mean_f1, kSaneF1);
      if (!row.note.empty()) continue;
      timed_rows.push_back(&row);
      timed_runners.push_back(&runners[i]);
    }
    time_row(scenes[s], timed_rows, timed_runners, options);
  }
  return rows;
}

}  // namespace fransac::bench
