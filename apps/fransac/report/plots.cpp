// SPDX-License-Identifier: Apache-2.0
#include "plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string_view>

#include "html.hpp"

namespace fransac::cli::report {
namespace {

// Units of the view box; the page scales the whole.
constexpr double kWidth = 600.0;
constexpr double kHeight = 340.0;
constexpr double kTop = 44.0;  // room for the legend
constexpr double kRight = kWidth - 24.0;
constexpr double kLetter = 7.4;  // a letter of a wide sans-serif at 12 px, the page's size of text in plots

struct Range {
  double min = 0.0;
  double max = 1.0;
};

/// Maps values to places on paper.
class Scale {
 public:
  Scale(Range values, double from, double to, bool logarithmic)
      : values_(values), from_(from), to_(to), logarithmic_(logarithmic) {}
  double operator()(double value) const {
    const double share = logarithmic_ ? std::log(value / values_.min) / std::log(values_.max / values_.min)
                                      : (value - values_.min) / (values_.max - values_.min);
    return from_ + std::clamp(share, 0.0, 1.0) * (to_ - from_);
  }
  /// Round values: 1, 2 and 5 times powers of ten, or evenly spaced.
  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> marks;
    if (logarithmic_) {
      for (double decade = std::pow(10.0, std::floor(std::log10(values_.min))); decade <= values_.max; decade *= 10.0) {
        for (const double factor : {1.0, 2.0, 5.0}) add(marks, decade * factor);
      }
    } else {
      const double step = round_step((values_.max - values_.min) / 5.0);
      for (double k = std::ceil(values_.min / step - 1e-9); k * step <= values_.max * (1.0 + 1e-9); ++k) add(marks, k * step);
    }
    return marks;
  }
  /// The next round number: 1, 2 or 5 times a power of ten.
  static double round_step(double step) {
    const double decade = std::pow(10.0, std::floor(std::log10(step)));
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (step <= decade * factor * (1.0 + 1e-9)) return decade * factor;
    }
    return 10.0 * decade;
  }

 private:
  void add(std::vector<double>& marks, double value) const {
    if (value >= values_.min * (1.0 - 1e-9) && value <= values_.max * (1.0 + 1e-9)) marks.push_back(value);
  }

  Range values_;
  double from_;
  double to_;
  bool logarithmic_;
};

/// Limits with a little air: for a logarithmic axis down and up to the next of 1, 2, 5.
Range logarithmic_range(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  if (low == values.end()) return {1.0, 10.0};
  const double max = Scale::round_step(*high * 1.02);
  double min = Scale::round_step(*low);
  while (min > *low * 0.98) min = Scale::round_step(min * 0.4);  // 1, 2 and 5 are within a factor of 2.5
  return {min, max};
}

/// Where an axis up to 1 begins so that the lowest value has room.
double share_floor(double lowest) {
  constexpr double kFloors[] = {0.98, 0.95, 0.9, 0.8, 0.5};
  const auto* const below = std::find_if(std::begin(kFloors), std::end(kFloors), [&](double floor) { return floor < lowest; });
  return below == std::end(kFloors) ? 0.0 : *below;
}

std::string open_svg(const std::string& title, double height = kHeight) {
  return fmt::format("<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n<title>{}</title>\n", kWidth, height,
                     escape(title), escape(title));
}

std::string text(double x, double y, std::string_view anchor, std::string_view words, std::string_view attributes = {}) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}{}>{}</text>\n", x, y, anchor,
                     attributes.empty() ? "" : " ", attributes, escape(words));
}

std::string line(double x1, double y1, double x2, double y2, std::string_view style) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x1, y1, x2, y2, style);
}

std::string rectangle(double x, double y, double width, double height, std::string_view style, std::string_view told) {
  return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"{:.2f}\" class=\"{}\"><title>{}</title></rect>\n",
                     x, y, std::max(width, 0.5), std::max(height, 0.5), style, escape(told));
}

std::string series_class(std::size_t i) { return fmt::format("s{}", i % 6 + 1); }

/// Circle, square, triangle, diamond, then again.
std::string mark(double x, double y, double r, std::size_t i, std::string_view told, std::string_view extra = {}) {
  std::string path;
  switch (i % 4) {
    case 0: path = fmt::format("M{0:.1f} {1:.1f}a{2} {2} 0 1 0 {3} 0a{2} {2} 0 1 0 -{3} 0z", x - r, y, r, 2.0 * r); break;
    case 1: path = fmt::format("M{0:.1f} {1:.1f}h{2}v{2}h-{2}z", x - 0.9 * r, y - 0.9 * r, 1.8 * r); break;
    case 2: path = fmt::format("M{0:.1f} {1:.1f}l{2} {3}h-{4}z", x, y - 1.1 * r, 1.1 * r, 2.0 * r, 2.2 * r); break;
    default: path = fmt::format("M{0:.1f} {1:.1f}l{2} {2}l-{2} {2}l-{2} -{2}z", x, y - 1.3 * r, 1.3 * r);
  }
  return fmt::format("<path d=\"{}\" class=\"mark {} {}\"><title>{}</title></path>\n", path, series_class(i), extra,
                     escape(told));
}

std::string part_class(std::size_t i) { return fmt::format("part-s{}", i % 8 + 1); }

/// Names of the series side by side above the plot, in two rows if need be; `marks` as in the plot or squares. Nameless series
/// have no place.
std::string legend(const std::vector<std::string>& names, bool marks, std::string (*style)(std::size_t) = series_class) {
  constexpr double kStart = 14.0;
  constexpr double kRow = 16.0;
  std::string svg;
  double x = kStart;
  double y = 0.0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) continue;
    const double width = 36.0 + kLetter * static_cast<double>(names[i].size());
    if (x > kStart && x + width > kWidth) {
      x = kStart;
      y += kRow;
    }
    svg += marks ? mark(x + 5.0, y + 16.0, 5.0, i, names[i]) : rectangle(x, y + 11.0, 11.0, 11.0, style(i), names[i]);
    svg += text(x + 16.0, y + 20.0, "start", names[i]);
    x += width;
  }
  return svg;
}

template <class T>
std::vector<std::string> names_of(const std::vector<T>& items) {
  std::vector<std::string> names;
  for (const T& item : items) names.push_back(item.name);
  return names;
}

std::string number(double value) { return fmt::format("{:.6g}", value + 0.0); }  // no "-0"

std::string y_axis(const Scale& scale, const std::string& title, double left, double bottom) {
  std::string svg;
  for (const double tick : scale.ticks()) {
    svg += line(left, scale(tick), kRight, scale(tick), "grid");
    svg += text(left - 6.0, scale(tick) + 4.0, "end", number(tick));
  }
  if (title.empty()) return svg;
  const double middle = 0.5 * (kTop + bottom);
  return svg + text(14.0, middle, "middle", title, fmt::format("transform=\"rotate(-90 14 {:.1f})\"", middle));
}

std::string x_axis(const Scale& scale, const std::string& title, double left, double bottom) {
  std::string svg;
  for (const double tick : scale.ticks()) {
    svg += line(scale(tick), kTop, scale(tick), bottom, "grid");
    svg += text(scale(tick), bottom + 16.0, "middle", number(tick));
  }
  return svg + text(0.5 * (left + kRight), bottom + 36.0, "middle", title);
}

/// A name that fits: its end tells one frame from the next.
std::string shortened(const std::string& name) {
  constexpr std::size_t kLongest = 14;
  return name.size() <= kLongest ? name : "…" + name.substr(name.size() - kLongest);
}

double longest(const std::vector<std::string>& names) {
  std::size_t letters = 0;
  for (const std::string& name : names) letters = std::max(letters, std::min<std::size_t>(name.size(), 15));
  return kLetter * static_cast<double>(letters);
}

/// Where the categories stand on a horizontal axis and how their names fit under it.
struct Columns {
  double left;
  double step;
  bool upright;       // names stand on end
  std::size_t every;  // which names there is room for
  double bottom;

  Columns(const std::vector<std::string>& names, double from)
      : left(from),
        step((kRight - left) / static_cast<double>(std::max<std::size_t>(names.size(), 1))),
        upright(longest(names) + 8.0 > step),
        every(upright ? static_cast<std::size_t>(std::ceil(15.0 / step)) : 1),
        bottom(kHeight - 12.0 - (upright ? longest(names) : 16.0)) {}
  [[nodiscard]] double middle(std::size_t i) const { return left + (static_cast<double>(i) + 0.5) * step; }
  [[nodiscard]] std::string names(const std::vector<std::string>& categories) const {
    std::string svg;
    for (std::size_t i = 0; i < categories.size(); i += every) {
      const double x = middle(i);
      const double y = bottom + (upright ? 8.0 : 18.0);
      svg += upright ? text(x + 4.0, y, "end", shortened(categories[i]),
                            fmt::format("transform=\"rotate(-90 {:.1f} {:.1f})\"", x + 4.0, y))
                     : text(x, y, "middle", shortened(categories[i]));
    }
    return svg;
  }
};

std::string told(const std::string& series, const std::string& category, double value, int decimals) {
  return fmt::format("{}, {}: {:.{}f}", series, category, value, decimals);
}

}  // namespace

std::string line_plot(const std::string& title, const Axis& y, const std::vector<std::string>& categories,
                      const std::vector<Series>& series) {
  const Columns columns(categories, 58.0);
  std::vector<double> all;
  for (const Series& one : series) {
    for (const auto& value : one.values) {
      if (value) all.push_back(*value);
    }
  }
  const Range range = y.logarithmic ? logarithmic_range(all) : Range{};
  const Scale scale(range, columns.bottom, kTop, y.logarithmic);
  std::string svg = open_svg(title) + legend(names_of(series), true) + y_axis(scale, y.title, columns.left, columns.bottom);
  svg += columns.names(categories);
  for (std::size_t s = 0; s < series.size(); ++s) {
    std::string path;
    std::string marks;
    const double radius = columns.step < 16.0 ? 3.0 : 4.5;
    for (std::size_t i = 0; i < categories.size(); ++i) {
      const auto& value = series[s].values[i];
      if (!value) continue;
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", columns.middle(i), scale(*value));
      marks += mark(columns.middle(i), scale(*value), radius, s, told(series[s].name, categories[i], *value, y.decimals));
    }
    if (!path.empty()) svg += fmt::format("<path d=\"{}\" class=\"line {}\"/>\n", path, series_class(s));
    svg += marks;
  }
  return svg + "</svg>\n";
}

std::string share_bars(const std::string& title, const std::vector<std::string>& categories, const std::vector<Series>& series) {
  const Columns columns(categories, 44.0);
  const Scale scale({}, columns.bottom, kTop + 10.0, false);
  std::string svg = open_svg(title) + legend(names_of(series), false) + y_axis(scale, "", columns.left, columns.bottom);
  svg += columns.names(categories);
  const double bar = 0.86 * columns.step / static_cast<double>(std::max<std::size_t>(series.size(), 1));
  for (std::size_t s = 0; s < series.size(); ++s) {
    for (std::size_t i = 0; i < categories.size(); ++i) {
      const auto& value = series[s].values[i];
      if (!value) continue;
      const double x = columns.middle(i) + (static_cast<double>(s) - 0.5 * static_cast<double>(series.size())) * bar;
      svg += rectangle(x + 1.0, scale(*value), bar - 2.0, columns.bottom - scale(*value), series_class(s),
                       told(series[s].name, categories[i], *value, 4));
      if (bar > 5.0 * kLetter)
        svg += text(x + 0.5 * bar, scale(*value) - 4.0, "middle", fmt::format("{:.3f}", *value), "class=\"value\"");
    }
  }
  return svg + "</svg>\n";
}

std::string stacked_bars(const std::string& title, const Axis& x, const std::vector<std::string>& categories,
                         const std::vector<Series>& series) {
  constexpr double kBar = 30.0;
  constexpr double kStep = 44.0;
  std::vector<double> totals(categories.size(), 0.0);
  std::vector<std::string> names(series.size());
  for (std::size_t s = 0; s < series.size(); ++s) {
    for (std::size_t i = 0; i < totals.size(); ++i) {
      const double value = series[s].values[i].value_or(0.0);
      totals[i] += value;
      if (value > 0.0) names[s] = series[s].name;
    }
  }
  const double longest_bar = totals.empty() ? 0.0 : *std::max_element(totals.begin(), totals.end());
  const double left = 20.0 + longest(categories);
  const double bottom = kTop + kStep * static_cast<double>(categories.size());
  const double height = bottom + 42.0;
  const Scale scale({0.0, std::max(longest_bar * 1.14, 1e-6)}, left, kRight, false);
  std::string svg = open_svg(title, height) + legend(names, false, part_class) + x_axis(scale, x.title, left, bottom);
  for (std::size_t i = 0; i < categories.size(); ++i) {
    const double y = kTop + kStep * static_cast<double>(i) + 0.5 * (kStep - kBar);
    svg += text(left - 8.0, y + 0.5 * kBar + 4.0, "end", shortened(categories[i]));
    double before = 0.0;
    for (std::size_t s = 0; s < series.size(); ++s) {
      const double value = series[s].values[i].value_or(0.0);
      if (value <= 0.0) continue;
      svg += rectangle(scale(before), y, scale(before + value) - scale(before), kBar, part_class(s),
                       told(series[s].name, categories[i], value, x.decimals));
      before += value;
    }
    svg +=
        text(scale(before) + 6.0, y + 0.5 * kBar + 4.0, "start", fmt::format("{:.{}f}", before, x.decimals), "class=\"value\"");
  }
  return svg + "</svg>\n";
}

std::string scatter_plot(const std::string& title, const Axis& x, const Axis& y, const std::vector<Cloud>& clouds) {
  constexpr double kLeft = 58.0;
  constexpr double kBottom = kHeight - 46.0;
  std::vector<double> all;
  double lowest = 1.0;
  for (const Cloud& cloud : clouds) {
    all.push_back(cloud.mean.x);
    for (const Dot& dot : cloud.dots) {
      all.push_back(dot.x);
      lowest = std::min(lowest, dot.y);
    }
  }
  const Scale across(logarithmic_range(all), kLeft, kRight, true);
  const Scale up({share_floor(lowest), 1.0}, kBottom, kTop + 6.0, false);
  std::string svg = open_svg(title) + legend(names_of(clouds), true) + y_axis(up, y.title, kLeft, kBottom);
  svg += x_axis(across, x.title, kLeft, kBottom);
  const auto say = [&](const std::string& name, const Dot& dot) {
    return fmt::format("{}: {:.{}f} {}, {} {:.{}f}", name, dot.x, x.decimals, x.title, y.title, dot.y, y.decimals);
  };
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    for (const Dot& dot : clouds[c].dots) svg += mark(across(dot.x), up(dot.y), 3.0, c, say(clouds[c].name, dot), "pale");
  }
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    svg += mark(across(clouds[c].mean.x), up(clouds[c].mean.y), 7.0, c, say(clouds[c].name + ", mean", clouds[c].mean));
  }
  return svg + "</svg>\n";
}

std::string curve_plot(const std::string& title, const Axis& x, const Axis& y, const std::vector<Curve>& curves) {
  constexpr double kLeft = 58.0;
  constexpr double kBottom = kHeight - 46.0;
  constexpr double kRadius = 2.2;  // marks are close to each other
  constexpr double kAir = 1.05;
  constexpr double kLeast = 1e-6;  // a plot of nothing but zeros has a scale, too
  Range wide{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()};
  double highest = kLeast;
  for (const Curve& curve : curves) {
    for (const Dot& point : curve.points) {
      wide = {std::min(wide.min, point.x), std::max(wide.max, point.x)};
      highest = std::max(highest, kAir * point.y);
    }
  }
  const Scale across(wide, kLeft, kRight, false);
  const Scale up({0.0, highest}, kBottom, kTop + 10.0, false);
  std::string svg = open_svg(title) + legend(names_of(curves), true) + y_axis(up, y.title, kLeft, kBottom);
  svg += x_axis(across, x.title, kLeft, kBottom);
  for (std::size_t c = 0; c < curves.size(); ++c) {
    std::string path;
    std::string marks;
    for (const Dot& point : curves[c].points) {
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", across(point.x), up(point.y));
      marks += mark(across(point.x), up(point.y), kRadius, c,
                    told(curves[c].name, fmt::format("{} {:.{}f}", x.title, point.x, x.decimals), point.y, y.decimals));
    }
    if (!path.empty()) svg += fmt::format("<path d=\"{}\" class=\"line {}\"/>\n", path, series_class(c));
    svg += marks;
  }
  return svg + "</svg>\n";
}

std::string histogram(const std::string& title, const std::string& x, const std::string& counted,
                      const std::vector<double>& values, const std::vector<Mark>& marks) {
  constexpr double kLeft = 58.0;
  constexpr double kBottom = kHeight - 46.0;
  constexpr double kBars = 30.0;
  constexpr double kBeyond = 1.5;  // times the highest mark; what is slower still is counted together
  double highest = 1e-6;
  for (const Mark& mark : marks) highest = std::max(highest, kBeyond * mark.at);
  const double longest_value = values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
  const double step = Scale::round_step(std::min(highest, std::max(longest_value, 1e-6)) / kBars);
  const auto bars = static_cast<std::size_t>(std::ceil(std::min(highest, longest_value * 1.001) / step)) + 1;
  std::vector<double> counts(bars, 0.0);
  for (const double value : values) ++counts[std::min(static_cast<std::size_t>(value / step), bars - 1)];
  const Scale across({0.0, step * static_cast<double>(bars)}, kLeft, kRight, false);
  const double tallest = *std::max_element(counts.begin(), counts.end());
  constexpr double kLeastTall = 3.0;  // ticks at whole numbers
  const Scale up({0.0, std::max(tallest * 1.05, kLeastTall)}, kBottom, kTop, false);
  std::string svg = open_svg(title) + y_axis(up, counted, kLeft, kBottom) + x_axis(across, x, kLeft, kBottom);
  for (std::size_t i = 0; i < bars; ++i) {
    if (counts[i] == 0.0) continue;
    const double from = step * static_cast<double>(i);
    const std::string to = i + 1 == bars && longest_value > step * static_cast<double>(bars) ? "more" : number(from + step);
    svg += rectangle(across(from) + 0.5, up(counts[i]), across(step) - kLeft - 1.0, kBottom - up(counts[i]), "s1",
                     fmt::format("{} to {} {}: {:.0f} {}", number(from), to, x, counts[i], counted));
  }
  for (std::size_t m = 0; m < marks.size(); ++m) {
    const double at = across(marks[m].at);
    const double y = 18.0 + 14.0 * static_cast<double>(m);  // one above the other: they can be close
    const bool left = at > 0.5 * (kLeft + kRight);
    svg += line(at, y - 10.0, at, kBottom, "told");
    svg += text(at + (left ? -5.0 : 5.0), y, left ? "end" : "start", fmt::format("{} {:.2f}", marks[m].name, marks[m].at));
  }
  return svg + "</svg>\n";
}

std::string path_plot(const std::string& title, const std::string& x, const std::string& y, const std::vector<Dot>& points,
                      const std::vector<Arrow>& arrows) {
  constexpr double kLeft = 58.0;
  constexpr double kBottom = kHeight - 46.0;
  constexpr double kLeast = 0.1;  // metres: a camera that stands still has a plot, too
  constexpr double kAir = 1.15;
  constexpr double kStroke = 16.0;
  Range wide{points.front().x, points.front().x};
  Range tall{points.front().y, points.front().y};
  for (const Dot& point : points) {
    wide = {std::min(wide.min, point.x), std::max(wide.max, point.x)};
    tall = {std::min(tall.min, point.y), std::max(tall.max, point.y)};
  }
  const double unit = kAir * std::max({kLeast / (kBottom - kTop), (wide.max - wide.min) / (kRight - kLeft),
                                       (tall.max - tall.min) / (kBottom - kTop)});
  const auto around = [&](const Range& range, double length) {
    const double middle = 0.5 * (range.min + range.max);
    return Range{middle - 0.5 * length * unit, middle + 0.5 * length * unit};
  };
  const Scale across(around(wide, kRight - kLeft), kLeft, kRight, false);
  const Scale up(around(tall, kBottom - kTop), kBottom, kTop, false);
  std::string svg = open_svg(title) + legend({"start", "end"}, true) + y_axis(up, y, kLeft, kBottom);
  svg += x_axis(across, x, kLeft, kBottom);
  for (const Arrow& arrow : arrows) {
    const double from_x = across(arrow.at.x);
    const double from_y = up(arrow.at.y);
    svg += line(from_x, from_y, from_x + kStroke * arrow.towards.x, from_y - kStroke * arrow.towards.y, "stroke");
  }
  std::string path;
  for (const Dot& point : points) path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", across(point.x), up(point.y));
  svg += fmt::format("<path d=\"{}\" class=\"line s1\"/>\n", path);
  const auto end = [&](const Dot& point, std::size_t i, const char* name) {
    svg += mark(across(point.x), up(point.y), 5.0, i, fmt::format("{}: {:.2f}, {:.2f} m", name, point.x, point.y));
  };
  end(points.front(), 0, "start");
  end(points.back(), 1, "end");
  return svg + "</svg>\n";
}

}  // namespace fransac::cli::report
