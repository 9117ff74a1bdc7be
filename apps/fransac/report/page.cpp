// SPDX-License-Identifier: Apache-2.0
#include "page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "html.hpp"
#include "pictures.hpp"
#include "plots.hpp"

namespace fransac::cli::report {
namespace {

/// What tables show, and in which order, of what there is.
constexpr Quantity kShown[] = {
    Quantity::precision,      Quantity::recall,         Quantity::f1,           Quantity::best_f1,      Quantity::matched_f1,
    Quantity::instance_f1_50, Quantity::instance_f1_75, Quantity::weighted_iou, Quantity::angle_deg,    Quantity::offset_m,
    Quantity::hoover_regions, Quantity::hoover_correct, Quantity::hoover_over,  Quantity::hoover_under, Quantity::hoover_missed,
    Quantity::hoover_noise,   Quantity::planes,         Quantity::median_ms,    Quantity::fps};
/// The paper's tables and figure 4, scene by scene; instance metrics besides.
constexpr Quantity kPerScene[] = {Quantity::fps,
                                  Quantity::median_ms,
                                  Quantity::precision,
                                  Quantity::recall,
                                  Quantity::f1,
                                  Quantity::best_f1,
                                  Quantity::matched_f1,
                                  Quantity::instance_f1_50,
                                  Quantity::instance_f1_75,
                                  Quantity::weighted_iou,
                                  Quantity::hoover_correct,
                                  Quantity::hoover_noise};

constexpr const char* kOpen = " open=\"open\"";

std::string heading(Quantity quantity) {
  if (quantity == Quantity::median_ms) return "median [ms]";
  if (quantity == Quantity::planes) return "planes";
  return std::string(info_of(quantity).heading);
}

/// As `evaluate` prints it; a scene's number of planes is whole.
std::string shown_text(const Row& row, Quantity quantity) {
  const auto& value = row.scores[quantity];
  const bool whole = quantity == Quantity::planes && value && *value == std::floor(*value);
  return whole ? fmt::format("{:.0f}", *value) : value_text(row.scores, quantity);
}

bool present(const std::vector<Row>& rows, Quantity quantity) {
  return std::any_of(rows.begin(), rows.end(), [&](const Row& row) { return row.scores[quantity].has_value(); });
}

/// Which of the rows have the best of a quantity, as it is shown; none where nothing is better than anything.
std::vector<bool> best_of(const std::vector<Row>& rows, Quantity quantity) {
  constexpr Quantity kNeither[] = {Quantity::planes, Quantity::hoover_regions};
  constexpr Quantity kSmall[] = {Quantity::median_ms,    Quantity::angle_deg,     Quantity::offset_m,    Quantity::hoover_over,
                                 Quantity::hoover_under, Quantity::hoover_missed, Quantity::hoover_noise};
  const auto is_of = [&](const auto& quantities) {
    return std::find(std::begin(quantities), std::end(quantities), quantity) != std::end(quantities);
  };
  if (is_of(kNeither)) return std::vector<bool>(rows.size(), false);
  const bool small = is_of(kSmall);
  const Row* best = nullptr;
  for (const Row& row : rows) {
    const auto& value = row.scores[quantity];
    if (value && (best == nullptr || (small ? *value < *best->scores[quantity] : *value > *best->scores[quantity]))) best = &row;
  }
  std::vector<bool> marked;
  for (const Row& row : rows) {
    marked.push_back(best != nullptr && value_text(row.scores, quantity) == value_text(best->scores, quantity));
  }
  if (std::all_of(marked.begin(), marked.end(), [](bool mark) { return mark; })) marked.assign(rows.size(), false);
  return marked;
}

std::vector<std::string> method_names(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  for (const Row& row : rows) names.emplace_back(enum_name(row.method));
  return names;
}

/// Methods down, quantities across.
std::string method_table(const std::string& caption, const std::string& attributes, const std::vector<Row>& rows) {
  std::vector<Quantity> shown;
  std::copy_if(std::begin(kShown), std::end(kShown), std::back_inserter(shown), [&](Quantity q) { return present(rows, q); });
  std::vector<std::string> headings{"method"};
  std::vector<std::vector<bool>> best;
  for (const Quantity quantity : shown) {
    headings.push_back(heading(quantity));
    best.push_back(best_of(rows, quantity));
  }
  HtmlTable table(caption, headings, attributes);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    std::vector<std::string> cells{std::string(enum_name(rows[r].method))};
    std::vector<bool> marked{false};
    for (std::size_t q = 0; q < shown.size(); ++q) {
      cells.push_back(shown_text(rows[r], shown[q]));
      marked.push_back(best[q][r]);
    }
    table.add(cells, marked);
  }
  return table.text();
}

/// Scenes down, methods across, as the paper has them.
std::string scene_table(const DatasetReport& dataset, Quantity quantity) {
  std::vector<std::string> headings = method_names(dataset.means);
  headings.insert(headings.begin(), "scene");
  HtmlTable table(heading(quantity), headings, fmt::format("data-quantity=\"{}\"", info_of(quantity).key));
  const auto add = [&](const std::string& name, const std::vector<Row>& rows) {
    std::vector<std::string> cells{name};
    std::vector<bool> best = best_of(rows, quantity);
    best.insert(best.begin(), false);
    for (const Row& row : rows) cells.push_back(value_text(row.scores, quantity));
    table.add(cells, best);
  };
  for (const Scene& scene : dataset.scenes) add(scene.name, scene.rows);
  table.foot();
  add("mean", dataset.means);
  return table.text();
}

std::string scene_tables(const DatasetReport& dataset, bool open) {
  std::string html =
      fmt::format("<details class=\"fold\"{}>\n<summary>Tables</summary>\n<div class=\"tables\">\n", open ? kOpen : "");
  for (const Quantity quantity : kPerScene) {
    if (present(dataset.means, quantity)) html += scene_table(dataset, quantity);
  }
  return html + "</div></details>\n";
}

std::string fps_plot(const DatasetReport& dataset) {
  std::vector<std::string> scenes;
  std::vector<Series> series;
  for (const std::string& method : method_names(dataset.means)) series.push_back({method, {}});
  for (const Scene& scene : dataset.scenes) {
    scenes.push_back(scene.name);
    for (std::size_t m = 0; m < series.size(); ++m) series[m].values.push_back(scene.rows[m].scores[Quantity::fps]);
  }
  const std::string title = "Frames per second, scene by scene";
  return plot_figure(title, "As the paper's figure 4; logarithmic.",
                     line_plot(title, {"frames per second", true, 1}, scenes, series));
}

std::string accuracy_bars(const DatasetReport& dataset) {
  std::vector<std::string> quantities;
  std::vector<Series> series;
  for (const std::string& method : method_names(dataset.means)) series.push_back({method, {}});
  for (const Quantity quantity : {Quantity::precision, Quantity::recall, Quantity::f1}) {
    quantities.push_back(heading(quantity));
    for (std::size_t m = 0; m < series.size(); ++m) series[m].values.push_back(dataset.means[m].scores[quantity]);
  }
  const std::string title = "Precision, recall and F1";
  return plot_figure(title, "Of the dominant plane; means over the scenes.", share_bars(title, quantities, series));
}

std::string accuracy_against_speed(const DatasetReport& dataset) {
  std::vector<Cloud> clouds;
  const auto dot = [](const Row& row) {
    return Dot{row.scores[Quantity::fps].value_or(1.0), row.scores[Quantity::f1].value_or(0.0)};
  };
  for (std::size_t m = 0; m < dataset.means.size(); ++m) {
    Cloud cloud{std::string(enum_name(dataset.means[m].method)), dot(dataset.means[m]), {}};
    for (const Scene& scene : dataset.scenes) cloud.dots.push_back(dot(scene.rows[m]));
    clouds.push_back(std::move(cloud));
  }
  const std::string title = "Accuracy against speed";
  return plot_figure(title, "Large marks: means; pale: scenes. Up and to the right is better.",
                     scatter_plot(title, {"frames per second", true, 1}, {"F1", false, 4}, clouds));
}

std::string stage_plot(const DatasetReport& dataset) {
  std::vector<Series> stages;
  for (std::size_t s = 0; s < kStages; ++s) {
    stages.push_back({std::string(EnumNames<Stage>::values[s]), {}});
    for (const Row& row : dataset.means) stages.back().values.emplace_back(row.stage_ms[s]);
  }
  const std::string title = "Time by stage";
  return plot_figure(title, "Medians per scene, averaged over the scenes.",
                     stacked_bars(title, {"milliseconds", false, 2}, method_names(dataset.means), stages));
}

/// Means over the scenes that have true regions, one curve per method that was asked for all planes.
std::vector<Curve> hoover_curves(const DatasetReport& dataset, int eval::HooverMetrics::*count) {
  std::vector<Curve> curves;
  const std::vector<std::string> methods = method_names(dataset.means);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    Curve curve{methods[m], {}};
    double scenes = 0.0;
    for (const Scene& scene : dataset.scenes) {
      const std::vector<eval::HooverMetrics>& of_scene = scene.rows[m].hoover_curve;
      if (of_scene.empty()) continue;
      ++scenes;
      curve.points.resize(of_scene.size());
      for (std::size_t i = 0; i < of_scene.size(); ++i) {
        curve.points[i].x = of_scene[i].tolerance;
        curve.points[i].y += of_scene[i].*count;
      }
    }
    for (Dot& point : curve.points) point.y /= scenes;
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

std::string hoover_plots(const DatasetReport& dataset) {
  if (!present(dataset.means, Quantity::hoover_regions)) return "";
  const double regions = std::find_if(dataset.means.begin(), dataset.means.end(),
                                      [](const Row& row) { return row.scores[Quantity::hoover_regions].has_value(); })
                             ->scores[Quantity::hoover_regions]
                             .value_or(0.0);
  const auto plot = [&](const std::string& title, const std::string& note, int eval::HooverMetrics::*count) {
    return plot_figure(title, note,
                       curve_plot(title, {"tolerance", false, 2}, {"regions a scene", false, 2}, hoover_curves(dataset, count)));
  };
  return plot("Correct regions over tolerance",
              fmt::format("As Hoover et al. (1996) classify them; means over the scenes, of {:.1f} true regions.", regions),
              &eval::HooverMetrics::correct) +
         plot("Noise regions over tolerance", "Found, and neither correct nor part of an over- or under-segmentation.",
              &eval::HooverMetrics::noise);
}

bool judged(const DatasetReport& dataset) { return present(dataset.means, Quantity::f1); }

std::string plots(const DatasetReport& dataset) {
  std::string html = "<div class=\"plots\">\n" + fps_plot(dataset);
  if (judged(dataset)) html += accuracy_bars(dataset) + accuracy_against_speed(dataset);
  return html + hoover_plots(dataset) + stage_plot(dataset) + "</div>\n";
}

/// Under the depth picture: which colour is how far.
std::string depth_legend(const io::DepthRange& range) {
  constexpr int kStops = 16;
  constexpr int kTicks = 4;
  std::string stops;
  for (int i = 0; i <= kStops; ++i) stops += ", " + css_colour(depth_colour(static_cast<double>(i) / kStops));
  std::string ticks;
  for (int i = 0; i <= kTicks; ++i) {
    const double share = static_cast<double>(i) / kTicks;
    ticks += fmt::format("<span>{:.2f}{}</span>",
                         std::lerp(static_cast<double>(range.nearest_m), static_cast<double>(range.farthest_m), share),
                         i == kTicks ? " m" : "");
  }
  return fmt::format(
      "<span class=\"ramp\" style=\"background: linear-gradient(to right{})\"></span><span class=\"ticks\">{}</span>", stops,
      ticks);
}

std::string gallery(const std::string& title, const std::vector<Picture>& pictures, const io::DepthRange& range) {
  if (pictures.empty()) return "";
  std::string html = title.empty() ? "" : fmt::format("<h4>{}</h4>\n", escape(title));
  html += "<div class=\"pictures\">\n";
  for (const Picture& picture : pictures) html += figure(picture, picture.title == "Depth" ? depth_legend(range) : "");
  return html + "</div>\n";
}

std::string difference_legend() {
  const auto item = [](const Colour& colour, const char* words) { return fmt::format("<li>{}{}</li>", swatch(colour), words); };
  return "<ul class=\"legend\">" + item(kHitColour, "found") + item(kMissedColour, "missed") + item(kFalseColour, "false") +
         item(kRestColour, "rightly left out") + item(kNothingColour, "no depth, or not judged") + "</ul>\n";
}

/// "fransac F1 0.9926, 11.5 ms": what a folded scene tells.
std::string gist(const Scene& scene) {
  std::string text;
  for (const Row& row : scene.rows) {
    text += fmt::format("{}{} ", text.empty() ? "" : " · ", enum_name(row.method));
    text += row.scores[Quantity::f1] ? value_text(row.scores, Quantity::f1).substr(0, 5)
                                     : value_text(row.scores, Quantity::median_ms) + " ms";
  }
  return (present(scene.rows, Quantity::f1) ? "F1: " : "") + text;
}

/// Every plane with what it is.
std::string planes_table(const FoundPlanes& found, const std::string& scene) {
  std::string caption = fmt::format("Planes of {} in {}", enum_name(found.method), scene);
  if (found.up_source != UpSource::none) caption += fmt::format(", up {}", enum_name(found.up_source));
  HtmlTable table(caption, {"plane", "kind", "area [m²]", "rms [mm]", "confidence", "pixels", "normal", "distance [m]"},
                  "class=\"of-planes\"");
  for (const FoundPlane& plane : found.planes) {
    const Eigen::Vector3d& n = plane.plane.normal;
    table.add({std::to_string(plane.id), std::string(enum_name(plane.kind)), fmt::format("{:.3f}", plane.area_m2),
               fmt::format("{:.1f}", 1e3 * plane.rms_m), fmt::format("{:.2f}", plane.confidence), std::to_string(plane.inliers),
               fmt::format("{:.3f} {:.3f} {:.3f}", n.x(), n.y(), n.z()), fmt::format("{:.3f}", plane.plane.d)},
              {}, swatch(io::label_colour(plane.colour)));
  }
  return fmt::format("<details class=\"fold\">\n<summary>{} plane{} of {}</summary>\n{}</details>\n", found.planes.size(),
                     found.planes.size() == 1 ? "" : "s", enum_name(found.method), table.text());
}

std::string scene_section(const Scene& scene, const std::string& id, bool open) {
  std::string html = fmt::format("<details class=\"scene\" id=\"{}\"{}>\n<summary>{} <small>{}</small></summary>\n", id,
                                 open ? kOpen : "", escape(scene.name), escape(gist(scene)));
  html += gallery("", scene.views, scene.range) + gallery("Planes found", scene.planes, scene.range);
  for (const FoundPlanes& found : scene.found) html += planes_table(found, scene.name);
  html += gallery("Differences from the dominant plane", scene.differences, scene.range);
  return html + method_table("Methods on " + scene.name, "class=\"of-scene\"", scene.rows) + "</details>\n";
}

std::string truth_text(const DatasetReport& dataset) {
  if (!judged(dataset)) return "This dataset has no truth, so there are pictures and times, but no accuracy and no differences.";
  if (dataset.truth == io::Truth::dominant) {
    return "The truth of this dataset is its dominant plane alone: metrics of single planes (F1@0.5 and so on) do not apply.";
  }
  if (!present(dataset.means, Quantity::instance_f1_50)) {
    return "The truth holds all planes, but one plane per scene was asked for: metrics of single planes (F1@0.5 and so on) need "
           "--planes all.";
  }
  std::string text =
      "The truth holds all planes. F1@0.5 and F1@0.75 match planes by intersection over union; wIoU is weighted by area.";
  const auto lacks = [](const Row& row) { return !row.scores[Quantity::instance_f1_50]; };
  if (std::any_of(dataset.means.begin(), dataset.means.end(), lacks)) {
    text += " Methods without them were asked for one plane per scene; --planes all asks for more.";
  }
  return text;
}

std::string regions_text(const DatasetReport& dataset, const HooverRequest& request) {
  if (!present(dataset.means, Quantity::hoover_regions)) return "";
  return fmt::format(
      "<p>Regions are true ones; those found are correct, over-segmented, under-segmented, missed or noise at a tolerance of {}, "
      "as Hoover et al., <i>An Experimental Comparison of Range Image Segmentation Algorithms</i> (1996), classify them.</p>\n",
      request.tolerance);
}

std::string sequence_link(const SequenceLink& sequence, std::size_t compared) {
  std::string html = fmt::format("<p class=\"sequence\"><a href=\"{}\">The sequence over time</a>: {}.", escape(sequence.file),
                                 escape(sequence.gist));
  if (compared < sequence.frames) html += fmt::format(" The methods are compared on {} of its frames, evenly chosen.", compared);
  return html + "</p>\n";
}

std::string dataset_section(const DatasetReport& dataset, const Report& report, std::size_t number) {
  std::string html = fmt::format("<section class=\"dataset\" id=\"dataset{}\">\n<h2>{}</h2>\n", number, escape(dataset.name));
  html += fmt::format("<p class=\"facts\">{} scene{}{}</p>\n<p>{}</p>\n", dataset.scenes.size(),
                      dataset.scenes.size() == 1 ? "" : "s", dataset.sensor.empty() ? "" : ", sensor: " + escape(dataset.sensor),
                      escape(truth_text(dataset)));
  html += regions_text(dataset, report.runs.hoover);
  if (dataset.sequence) html += sequence_link(*dataset.sequence, dataset.scenes.size());
  html += method_table("Means over the scenes", "class=\"of-means\"", dataset.means) + plots(dataset);
  html += "<h3>Scene by scene</h3>\n" + scene_tables(dataset, dataset.scenes.size() <= report.open_scenes);
  html += "<h3>Pictures</h3>\n<p class=\"note\">";
  html += judged(dataset) ? "A plane has the colour of the true plane that most of it lies on; planes that are none have further "
                            "colours. Grey is on no plane."
                          : "Planes are coloured in each method's order. Grey is on no plane.";
  html += " Black is without depth.</p>\n";
  if (judged(dataset))
    html +=
        "<p class=\"note\">Differences show the first plane of each method that can be judged against the dominant true "
        "plane:</p>\n" +
        difference_legend();
  for (std::size_t i = 0; i < dataset.scenes.size(); ++i) {
    html += scene_section(dataset.scenes[i], fmt::format("dataset{}-scene{}", number, i + 1), i < report.open_scenes);
  }
  return html + "</section>\n";
}

std::string contents(const Report& report) {
  if (report.datasets.size() < 2) return "";
  std::string html = "<nav aria-label=\"Datasets\"><ul>";
  for (std::size_t i = 0; i < report.datasets.size(); ++i) {
    html += fmt::format("<li><a href=\"#dataset{}\">{}</a></li>", i + 1, escape(report.datasets[i].name));
  }
  return html + "</ul></nav>\n";
}

std::string introduction(const Report& report) {
  std::size_t scenes = 0;
  for (const DatasetReport& dataset : report.datasets) scenes += dataset.scenes.size();
  const std::size_t methods = report.runs.methods.size();
  std::string html = fmt::format("<header>\n<h1>Planes in depth frames</h1>\n<p class=\"lead\">{} method{} on {} scene{}.</p>\n",
                                 methods, methods == 1 ? "" : "s", scenes, scenes == 1 ? "" : "s");
  html +=
      "<p>Precision, recall and F1 compare each method's first plane with the scene's dominant plane (equations 3 to 5 of "
      "Zeineldin and El-Fishawy, <i>FRANSAC: Fast RANdOm Sample Consensus for 3D Plane Segmentation</i>, 2017); best F1 takes "
      "the plane that overlaps it most, matched the true plane that the first one fits best. Times are from the depth frame in "
      "memory to labels in memory.</p>\n";
  html += fmt::format("<p class=\"facts\">{}, threads {}; median of {} run{} per frame.</p>\n", escape(to_text(report.machine)),
                      report.runs.options.threads, report.runs.repeat, report.runs.repeat == 1 ? "" : "s");
  return html + contents(report) + "</header>\n";
}

std::string option_text(const nlohmann::ordered_json& value) {
  if (value.is_null()) return "by method";
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_object()) return value.dump();
  std::string chosen;
  for (const auto& [name, part] : value.items()) {
    if (!part.is_null()) chosen += fmt::format("{}{}={}", chosen.empty() ? "" : " ", name, part.dump());
  }
  return chosen.empty() ? "by sensor" : chosen;
}

}  // namespace

std::string options_text(const SegmentOptions& options) {
  std::string text;
  const auto json = options_to_json(options);
  for (const auto& [name, value] : json.items()) {
    if (name == "method") continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, option_text(value));
  }
  return text;
}

std::string page(const Report& report) {
  std::string body = introduction(report) + "<main>\n";
  for (std::size_t i = 0; i < report.datasets.size(); ++i) body += dataset_section(report.datasets[i], report, i + 1);
  body +=
      fmt::format("</main>\n<footer><p>Options of all methods: {}.</p></footer>\n", escape(options_text(report.runs.options)));
  return document("Planes in depth frames", body);
}

}  // namespace fransac::cli::report
