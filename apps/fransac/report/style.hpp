// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace fransac::cli::report {

/// The page's style sheet. Free of '<' and '&', so that it is the same in HTML and XML. The series' colours are those of Okabe
/// and Ito, "Color Universal Design" (2008), lighter in the dark scheme; stages have steps of lightness.
inline constexpr std::string_view kStyle = R"css(
:root { color-scheme: light dark;
  --paper: #ffffff; --panel: #f5f6f8; --ink: #1c2127; --faint: #59636e; --rule: #d5dae0; --best: #0a6b4d; --link: #0b61a4;
  --s1: #0072b2; --s2: #d98a00; --s3: #009e73; --s4: #b8598f; --s5: #6f7780; --s6: #c04f00;
  --p1: #16324f; --p2: #3f6f9f; --p3: #86b5d6; --p4: #e0a53a;
  --p5: #1c6b4a; --p6: #4ea37c; --p7: #a3d6bd; --p8: #9aa3ad; }
@media (prefers-color-scheme: dark) { :root {
  --paper: #14171b; --panel: #1d2126; --ink: #e4e8ec; --faint: #9aa5b1; --rule: #343b44; --best: #5fd3a8; --link: #7cb8ec;
  --s1: #4ea6e0; --s2: #f0ad2e; --s3: #2fc796; --s4: #e39ac2; --s5: #a3acb6; --s6: #ee8147;
  --p1: #5b8fc4; --p2: #8db9de; --p3: #c4dff2; --p4: #f0ad2e;
  --p5: #3d9b74; --p6: #74c6a3; --p7: #bfe8d6; --p8: #7b858f; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); font: 16px/1.55 system-ui, -apple-system, "Segoe UI", "Noto Sans", "DejaVu Sans", sans-serif; }
header, main, footer { max-width: 1240px; margin: 0 auto; padding: 0 24px; }
header { padding-top: 36px; }
footer { padding-top: 12px; padding-bottom: 48px; color: var(--faint); font-size: 14px; }
h1 { overflow-wrap: anywhere; font-size: 32px; line-height: 1.2; letter-spacing: -0.01em; margin: 0 0 6px; }
h2 { font-size: 24px; line-height: 1.25; margin: 48px 0 6px; padding-top: 20px; border-top: 2px solid var(--rule); overflow-wrap: anywhere; }
h3 { font-size: 19px; margin: 32px 0 8px; }
.fold summary { font-size: 15px; }
h4 { font-size: 15px; margin: 18px 0 8px; }
p { margin: 6px 0 12px; max-width: 80ch; }
a { color: var(--link); }
.lead { font-size: 18px; }
.facts, .note, figcaption small { color: var(--faint); }
.facts { font-size: 14px; overflow-wrap: anywhere; }
nav ul { list-style: none; margin: 12px 0; padding: 0; display: flex; flex-wrap: wrap; gap: 4px 18px; }
.tables { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 560px), 1fr)); gap: 22px 32px; align-items: start; }
.scroll { overflow-x: auto; margin: 8px 0; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; width: 100%; }
caption { text-align: left; font-weight: 600; padding: 4px 0; }
th, td { padding: 4px 10px; text-align: right; white-space: nowrap; }
th:first-child { text-align: left; padding-left: 0; }
thead th { border-bottom: 1px solid var(--rule); color: var(--faint); font-weight: 600; }
tbody th { font-weight: 500; white-space: normal; overflow-wrap: anywhere; min-width: 6.5em; }
tbody tr + tr td, tbody tr + tr th { border-top: 1px solid color-mix(in srgb, var(--rule) 55%, transparent); }
tbody.mean th, tbody.mean td { border-top: 1px solid var(--ink); font-weight: 600; }
.best { color: var(--best); font-weight: 700; }
.plots { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 520px), 1fr)); gap: 20px; margin: 18px 0; }
figure { margin: 0; }
.plots figure { background: var(--panel); border-radius: 10px; padding: 14px 14px 8px; }
.plots figcaption { font-weight: 600; margin-bottom: 2px; }
.plots figcaption small { display: block; font-weight: 400; }
svg { display: block; width: 100%; height: auto; }
svg text { font: 12px system-ui, "DejaVu Sans", sans-serif; fill: var(--ink); }
svg text.value { font-size: 11px; fill: var(--faint); }
svg .grid { stroke: var(--rule); stroke-width: 1; }
svg .line { fill: none; stroke-width: 1.8; opacity: 0.75; }
svg .mark { stroke: var(--panel); stroke-width: 1; }
svg .pale { opacity: 0.4; }
svg .told { stroke: var(--ink); stroke-width: 1; stroke-dasharray: 4 3; }
svg .stroke { stroke: var(--s5); stroke-width: 1.5; }
.s1 { fill: var(--s1); } .s2 { fill: var(--s2); } .s3 { fill: var(--s3); } .s4 { fill: var(--s4); } .s5 { fill: var(--s5); } .s6 { fill: var(--s6); }
.line.s1 { stroke: var(--s1); } .line.s2 { stroke: var(--s2); } .line.s3 { stroke: var(--s3); } .line.s4 { stroke: var(--s4); } .line.s5 { stroke: var(--s5); } .line.s6 { stroke: var(--s6); }
.part-s1 { fill: var(--p1); } .part-s2 { fill: var(--p2); } .part-s3 { fill: var(--p3); } .part-s4 { fill: var(--p4); } .part-s5 { fill: var(--p5); } .part-s6 { fill: var(--p6); } .part-s7 { fill: var(--p7); } .part-s8 { fill: var(--p8); }
.legend { display: flex; flex-wrap: wrap; gap: 4px 20px; list-style: none; padding: 0; margin: 8px 0 12px; font-size: 14px; }
.swatch { display: inline-block; width: 13px; height: 13px; border-radius: 3px; margin-right: 7px; vertical-align: -1px; border: 1px solid var(--rule); }
details { border-top: 1px solid var(--rule); }
summary { cursor: pointer; padding: 10px 0; font-size: 18px; font-weight: 600; overflow-wrap: anywhere; }
summary small { font-weight: 400; font-size: 14px; color: var(--faint); margin-left: 10px; }
details > :last-child { margin-bottom: 26px; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(46%, 250px), 1fr)); gap: 14px; margin-bottom: 16px; }
.pictures img { display: block; width: 100%; height: auto; border-radius: 6px; background: #101014; }
.pictures figcaption { font-size: 14px; font-weight: 600; line-height: 1.35; padding-top: 5px; }
.pictures figcaption small { font-weight: 400; display: block; font-size: 13px; }
.thumbnails { grid-template-columns: repeat(auto-fill, minmax(min(30%, 170px), 1fr)); }
.timeline .time { width: 60%; min-width: 140px; padding: 4px 10px; }
.timeline .ticks { color: inherit; }
.timeline svg { width: 100%; height: 14px; background: var(--panel); border-radius: 2px; }
.ramp { display: block; height: 9px; border-radius: 3px; margin: 3px 0 1px; }
.ticks { display: flex; justify-content: space-between; font-weight: 400; font-size: 12px; color: var(--faint); font-variant-numeric: tabular-nums; }
@media (max-width: 640px) { header, main, footer { padding-left: 14px; padding-right: 14px; } h1 { font-size: 26px; } h2 { font-size: 21px; } .plots figure { padding: 10px 6px 4px; } .pictures { gap: 10px; } svg text { font-size: 13px; } }
@media print { details { break-inside: avoid; } }
)css";

}  // namespace fransac::cli::report
