// SPDX-License-Identifier: Apache-2.0
#include "html.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>

#include "style.hpp"

namespace fransac::cli::report {
namespace {

/// The JSON writer replaces what is no UTF-8.
std::string valid_utf8(std::string_view text) {
  using nlohmann::json;
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

}  // namespace

std::string escape(std::string_view text) {
  std::string escaped;
  for (const char c : valid_utf8(text)) {
    switch (c) {
      case '&': escaped += "&amp;"; break;
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '"': escaped += "&quot;"; break;
      case '\'': escaped += "&#39;"; break;
      case '\t':
      case '\n':
      case '\r': escaped += ' '; break;
      default: escaped += static_cast<unsigned char>(c) < 0x20 ? std::string("\xEF\xBF\xBD") : std::string(1, c);  // U+FFFD
    }
  }
  return escaped;
}

std::string png_uri(std::span<const std::byte> png) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";  // RFC 4648
  std::string uri = "data:image/png;base64,";
  uri.reserve(uri.size() + (png.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < png.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < png.size() ? std::to_integer<std::uint32_t>(png[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) uri += i + k <= png.size() ? kDigits[bits >> (18 - 6 * k) & 63U] : '=';
  }
  return uri;
}

std::string css_colour(const Colour& colour) { return fmt::format("rgb({},{},{})", colour[0], colour[1], colour[2]); }

std::string swatch(const Colour& colour) {
  return fmt::format("<span class=\"swatch\" style=\"background: {}\"></span>", css_colour(colour));
}

std::string figure(const Picture& picture, std::string_view legend) {
  return fmt::format(
      "<figure><img src=\"{}\" alt=\"{}\" width=\"{}\" height=\"{}\" decoding=\"async\"/>"
      "<figcaption>{}{}{}</figcaption></figure>\n",
      picture.uri, escape(picture.alt), picture.width, picture.height, escape(picture.title), legend,
      picture.note.empty() ? "" : fmt::format(" <small>{}</small>", escape(picture.note)));
}

std::string plot_figure(std::string_view title, std::string_view note, std::string_view svg) {
  return fmt::format("<figure><figcaption>{} <small>{}</small></figcaption>\n{}</figure>\n", escape(title), escape(note), svg);
}

std::string document(std::string_view title, std::string_view body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{}</title>\n<style>{}</style>\n</head>\n"
      "<body>\n{}</body>\n</html>\n",
      escape(title), kStyle, body);
}

HtmlTable::HtmlTable(std::string_view caption, std::vector<std::string> headings, std::string attributes) {
  head_ = fmt::format("<div class=\"scroll\"><table{}{}>\n<caption>{}</caption>\n<thead><tr>", attributes.empty() ? "" : " ",
                      attributes, escape(caption));
  for (const std::string& heading : headings) head_ += fmt::format("<th scope=\"col\">{}</th>", escape(heading));
  head_ += "</tr></thead>\n<tbody>\n";
}

void HtmlTable::add(const std::vector<std::string>& cells, const std::vector<bool>& best, std::string_view mark) {
  body_ += "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool marked = i < best.size() && best[i];
    body_ += i == 0 ? fmt::format("<th scope=\"row\">{}{}</th>", mark, escape(cells[i]))
                    : fmt::format("<td{}>{}</td>", marked ? " class=\"best\"" : "", escape(cells[i]));
  }
  body_ += "</tr>\n";
}

void HtmlTable::foot() { body_ += "</tbody>\n<tbody class=\"mean\">\n"; }

std::string HtmlTable::text() const { return head_ + body_ + "</tbody></table></div>\n"; }

}  // namespace fransac::cli::report
