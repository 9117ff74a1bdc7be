// SPDX-License-Identifier: Apache-2.0
/// Plots as inline SVG. Colours are the page's (classes s1, s2, … of the series; currentColor for the rest), so they follow
/// its light and dark schemes; series differ in shape as well as in colour, and every mark says its value to a pointer.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace fransac::cli::report {

/// A value per category; nothing where there is none.
struct Series {
  std::string name;
  std::vector<std::optional<double>> values;
};

struct Axis {
  std::string title;
  bool logarithmic = false;
  int decimals = 0;  ///< Of values that marks tell.
};

/// One mark per category and series, joined by lines.
std::string line_plot(const std::string& title, const Axis& y, const std::vector<std::string>& categories,
                      const std::vector<Series>& series);

/// Groups of bars from 0 to 1, one group per category, one bar per series.
std::string share_bars(const std::string& title, const std::vector<std::string>& categories, const std::vector<Series>& series);

/// One bar per category, its parts the series.
std::string stacked_bars(const std::string& title, const Axis& x, const std::vector<std::string>& categories,
                         const std::vector<Series>& series);

struct Dot {
  double x = 0.0;
  double y = 0.0;
};
struct Cloud {
  std::string name;
  Dot mean;
  std::vector<Dot> dots;  ///< Pale, what the mean is of.
};
/// y up to 1 against x; the scale of y begins below the lowest dot, not always at 0.
std::string scatter_plot(const std::string& title, const Axis& x, const Axis& y, const std::vector<Cloud>& clouds);

/// A named line through points, in their order.
struct Curve {
  std::string name;
  std::vector<Dot> points;
};
/// y from 0 on against x.
std::string curve_plot(const std::string& title, const Axis& x, const Axis& y, const std::vector<Curve>& curves);

/// A value told by a line through a plot.
struct Mark {
  std::string name;
  double at = 0.0;
};
/// How many values fall where, from 0 on; few values far above the highest mark are counted together in the last bar.
std::string histogram(const std::string& title, const std::string& x, const std::string& counted,
                      const std::vector<double>& values, const std::vector<Mark>& marks);

/// A short stroke; `towards` is of length 1 at most.
struct Arrow {
  Dot at;
  Dot towards;
};
/// A way with its start and its end, in the same scale along both axes.
std::string path_plot(const std::string& title, const std::string& x, const std::string& y, const std::vector<Dot>& points,
                      const std::vector<Arrow>& arrows);

}  // namespace fransac::cli::report
