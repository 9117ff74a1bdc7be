// SPDX-License-Identifier: Apache-2.0
/// Pieces of a page, well-formed as HTML and as XML.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fransac::cli::report {

/// Text for an element or an attribute: nothing in it is markup, whatever a file's name is; what is no UTF-8 is replaced.
std::string escape(std::string_view text);

/// "data:image/png;base64,…"
std::string png_uri(std::span<const std::byte> png);

using Colour = std::array<std::uint8_t, 3>;

/// A square of a colour, for legends and tables.
std::string swatch(const Colour& colour);
std::string css_colour(const Colour& colour);

struct Picture {
  std::string title;
  std::string note;  ///< May be empty.
  std::string alt;
  std::string uri;
  int width = 0;
  int height = 0;
};
/// A picture over its title, `legend` (markup) and note.
std::string figure(const Picture& picture, std::string_view legend = {});
/// A plot under its title and a note.
std::string plot_figure(std::string_view title, std::string_view note, std::string_view svg);

/// A whole page: `body` is markup, the title is not.
std::string document(std::string_view title, std::string_view body);

/// A table whose first column and first row are headings.
class HtmlTable {
 public:
  /// `attributes`: of the table element, escaped.
  HtmlTable(std::string_view caption, std::vector<std::string> headings, std::string attributes = {});
  /// The first cell heads the row, after `mark`, which is markup. `best[i]` marks cell i; may be empty.
  void add(const std::vector<std::string>& cells, const std::vector<bool>& best = {}, std::string_view mark = {});
  /// What follows sums up what came before.
  void foot();
  [[nodiscard]] std::string text() const;

 private:
  std::string head_;
  std::string body_;
};

}  // namespace fransac::cli::report
