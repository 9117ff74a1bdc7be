// SPDX-License-Identifier: Apache-2.0
#include "sequence_page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "../obstacle_output.hpp"
#include "../statistics.hpp"
#include "fransac/io/overlay.hpp"
#include "page.hpp"

namespace fransac::cli::report {
namespace {

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// The columns of time in which a thing was seen in all frames (`whole`), or in some; runs of columns are one shape.
std::string bar_path(const SequenceReport& sequence, const Seen& seen, bool whole) {
  std::string path;
  std::size_t begin = 0;
  std::size_t end = 0;
  const auto close = [&] {
    if (end > begin) path += fmt::format("M{} 0h{}v1h-{}z", begin, end - begin, end - begin);
  };
  for (const auto& [column, frames] : seen.spans) {
    if ((frames == sequence.frames_in(column)) != whole) continue;
    if (column != end) {
      close();
      begin = column;
    }
    end = column + 1U;
  }
  close();
  return path;
}

std::string bar(const SequenceReport& sequence, const Seen& seen, const std::string& colour, const std::string& told) {
  std::string svg =
      fmt::format("<svg viewBox=\"0 0 {} 1\" preserveAspectRatio=\"none\" role=\"img\" aria-label=\"{}\"><title>{}</title>",
                  sequence.columns(), escape(told), escape(told));
  for (const bool whole : {true, false}) {
    const std::string path = bar_path(sequence, seen, whole);
    if (path.empty()) continue;
    svg += fmt::format("<path d=\"{}\" fill=\"{}\"{}/>", path, colour, whole ? "" : " class=\"pale\"");
  }
  return svg + "</svg>";
}

/// "0 15 30 44 59": the frames' numbers over the bars.
std::string frame_ticks(std::size_t frames) {
  constexpr std::size_t kTicks = 5;
  std::string ticks;
  for (const std::size_t frame : evenly_chosen(frames, kTicks)) ticks += fmt::format("<span>{}</span>", frame);
  return fmt::format("<span class=\"ticks\">{}</span>", ticks);
}

/// The heaviest things, by id.
std::vector<int> shown_ids(const std::map<int, Seen>& things) {
  std::vector<int> ids;
  for (const auto& [id, seen] : things) ids.push_back(id);
  std::stable_sort(ids.begin(), ids.end(), [&](int a, int b) { return things.at(a).weight > things.at(b).weight; });
  ids.resize(std::min(ids.size(), kMostRows));
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::string area_text(const Seen& seen) { return fmt::format("{:.3f}", seen.weight / static_cast<double>(seen.frames)); }

std::string box_text(const Seen& seen) {
  const Eigen::Vector3d box = seen.box / static_cast<double>(seen.frames);
  return fmt::format("{:.2f} × {:.2f} × {:.2f}", box.x(), box.y(), box.z());
}

/// A row per id: when it was seen, what it is and how large.
std::string timeline(const SequenceReport& sequence, const std::map<int, Seen>& things, const std::string& what,
                     const std::string& size_heading, std::string (*size_text)(const Seen&)) {
  if (things.empty()) return "<p>None was seen.</p>\n";
  std::string html = fmt::format(
      "<div class=\"scroll\"><table class=\"timeline\" id=\"{0}s\">\n"
      "<caption>When each {0} was seen, by frame</caption>\n"
      "<thead><tr><th scope=\"col\">{0}</th><th scope=\"col\" class=\"time\">{1}</th><th scope=\"col\">frames</th>"
      "<th scope=\"col\">kind</th><th scope=\"col\">{2}</th></tr></thead>\n<tbody>\n",
      what, frame_ticks(sequence.frames), size_heading);
  const std::vector<int> ids = shown_ids(things);
  for (const int id : ids) {
    const Seen& seen = things.at(id);
    const Colour colour = io::label_colour(colour_label(id));
    const std::string told =
        fmt::format("{} {}: {} from {} to {}", what, id, counted(seen.frames, "frame"), seen.first, seen.last);
    html +=
        fmt::format("<tr><th scope=\"row\">{}{}</th><td class=\"time\">{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                    swatch(colour), id, bar(sequence, seen, css_colour(colour), told), seen.frames, seen.kind(), size_text(seen));
  }
  html += "</tbody></table></div>\n";
  if (ids.size() < things.size()) {
    html += fmt::format("<p class=\"note\">{} more, of which less was seen, are left out.</p>\n", things.size() - ids.size());
  }
  return html;
}

/// What was followed: pictures of it, then when each was seen. `what` is one of it, as in "plane".
std::string things_section(const std::string& what, const std::string& heading, const std::string& note,
                           const std::vector<Picture>& pictures, const std::string& when) {
  std::string html = fmt::format("<section id=\"{}s-section\">\n<h2>{}</h2>\n<p class=\"note\">{}</p>\n", what, heading, note);
  html += "<div class=\"pictures thumbnails\">\n";
  for (const Picture& one : pictures) html += figure(one);
  return html + fmt::format("</div>\n<h3>{} over time</h3>\n{}</section>\n", heading, when);
}

std::string planes_section(const SequenceReport& sequence) {
  return things_section("plane", "Planes",
                        "A plane has one colour for as long as it keeps its id. Grey is on no plane, black without depth.",
                        sequence.plane_pictures, timeline(sequence, sequence.planes, "plane", "mean area [m²]", area_text));
}

std::string objects_section(const SequenceReport& sequence) {
  if (!sequence.with_objects) return "";
  return things_section("object", "Objects",
                        "What stands on the support or hangs above it, each in one colour for as long as it keeps its id; "
                        "planes are pale. Drops are not followed. A size is length × width × height of the upright box.",
                        sequence.object_pictures, timeline(sequence, sequence.objects, "object", "mean size [m]", box_text));
}

std::string latency_plot(const SequenceReport& sequence) {
  const std::vector<double>& times = sequence.work_ms;
  const double middle = median(times);
  const double high = quantile(times, 0.99);
  const std::string title = "Time per frame";
  const std::string note = fmt::format(
      "From the depth frame in memory to ids, each frame from cold: median {:.2f} ms, p99 {:.2f} ms, longest {:.2f} ms. "
      "Decoding a frame takes {:.2f} ms besides (median).",
      middle, high, quantile(times, 1.0), sequence.totals.decode_ms.quantile(0.5));
  return plot_figure(title, note, histogram(title, "milliseconds", "frames", times, {{"median", middle}, {"p99", high}}));
}

std::string camera_plot(const SequenceReport& sequence) {
  const CameraPath& path = sequence.path;
  const std::string title = "The camera's path from above";
  std::string note =
      "Estimated from the planes; metres to the right and ahead of where it began. Strokes: where it looked in the frames above.";
  if (!path.up_is_known) note += " Nothing told what is up: the first frame's camera is taken to be level.";
  if (path.guessed > 0) {
    note += fmt::format(" In {} no plane told where it was, and it is as if the camera had moved on.",
                        counted(path.guessed, "frame"));
  }
  return plot_figure(title, note, path_plot(title, "right [m]", "ahead [m]", path.points, path.views));
}

std::string skipped_text(const SequenceReport& sequence) {
  if (sequence.totals.skipped == 0) return "";
  std::string html = fmt::format("<p>{} could not be used and {} skipped:</p>\n<ul class=\"skipped\">\n",
                                 counted(sequence.totals.skipped, "frame"), sequence.totals.skipped == 1 ? "is" : "are");
  for (const std::string& error : sequence.errors) html += fmt::format("<li>{}</li>\n", escape(error));
  if (sequence.errors.size() < sequence.totals.skipped) html += "<li>…</li>\n";
  return html + "</ul>\n";
}

}  // namespace

std::string gist(const SequenceReport& sequence) {
  std::string text = counted(sequence.totals.followed(), "frame");
  if (sequence.duration_s) text += fmt::format(" in {:.1f} s", *sequence.duration_s);
  text += ", " + counted(sequence.planes.size(), "plane");
  if (sequence.with_objects) text += ", " + counted(sequence.objects.size(), "object");
  return text +
         fmt::format(", median {:.2f} ms and p99 {:.2f} ms a frame", median(sequence.work_ms), quantile(sequence.work_ms, 0.99));
}

std::string sequence_page(const SequenceReport& sequence, const FollowRequest& request, const Machine& machine,
                          const std::string& index) {
  const double rate = 1e3 * static_cast<double>(sequence.totals.followed()) / std::max(sequence.totals.total_ms, 1e-3);
  std::string body = fmt::format(
      "<header>\n<nav><a href=\"{}\">Planes in depth frames</a></nav>\n<h1>{}</h1>\n<p class=\"lead\">{}.</p>\n"
      "<p class=\"facts\">Followed at {:.0f} frames a second from end to end, these pictures included. {}, threads "
      "{}.</p>\n{}</header>\n<main>\n",
      escape(index), escape(sequence.name), gist(sequence), rate, escape(to_text(machine)), request.options.threads,
      skipped_text(sequence));
  body += planes_section(sequence) + objects_section(sequence);
  body += "<section id=\"times\">\n<h2>Times and path</h2>\n<div class=\"plots\">\n" + latency_plot(sequence) +
          camera_plot(sequence) + "</div></section>\n</main>\n";
  body += fmt::format("<footer><p>Options of cells: {}.</p></footer>\n", escape(options_text(request.options)));
  return document(sequence.name, body);
}

}  // namespace fransac::cli::report
