#include "client/load/html_page.h"

#include "client/load/svg_plot.h"

namespace kerf::load {
namespace {

constexpr const char* kStyle = R"css(
:root { color-scheme: light dark; --ground: #fdfcfa; --text: #23211e; --faint: #6b665e; --line: #dcd7cd; --box: #f4f1ea; --warn: #9a4b00; --good: #2f7d4f;
  --c0: #1f5fa8; --c1: #c2410c; --c2: #2f7d4f; --c3: #7c3aad; --c4: #8a6d00; --c5: #0f7f8a; --c6: #b02a5b; --c7: #6b665e; }
@media (prefers-color-scheme: dark) { :root { --ground: #16181b; --text: #e8e4dc; --faint: #a39d92; --line: #34383d; --box: #1f2226;
  --warn: #ffb066; --good: #74c893; --c0: #7db4f0; --c1: #ff9966; --c2: #74c893; --c3: #c79bf0; --c4: #e0c15a; --c5: #5fc9d4; --c6: #f58bb0; --c7: #a39d92; } }
body { margin: 0 auto; max-width: 1320px; padding: 24px; background: var(--ground); color: var(--text);
  font: 15px/1.5 system-ui, sans-serif; }
h1 { font-size: 24px; margin: 0 0 4px; } h2 { font-size: 18px; margin: 32px 0 8px; } p { max-width: 80ch; } .faint, .none { color: var(--faint); }
.note { border-left: 4px solid var(--warn); padding: 4px 12px; margin: 8px 0; background: var(--box); }
.done { border-left: 4px solid var(--good); padding: 4px 12px; margin: 8px 0; background: var(--box); }
.numbers { display: grid; grid-template-columns: repeat(auto-fill, minmax(190px, 1fr)); gap: 12px; margin: 16px 0; }
.numbers div { background: var(--box); border-radius: 6px; padding: 10px 14px; } .numbers b { display: block; font-size: 22px; font-weight: 600; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 480px), 1fr)); gap: 16px; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; } th, td { padding: 3px 12px 3px 0; text-align: right; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; } th { color: var(--faint); font-weight: 500; } .wide { overflow-x: auto; }
td.better { color: var(--good); } td.worse { color: var(--warn); } svg.bar { width: 120px; background: none; border-radius: 0; }
.bar line { stroke: var(--faint); stroke-width: 8; } .bar line.better { stroke: var(--good); } .bar line.worse { stroke: var(--warn); }
svg { width: 100%; height: auto; background: var(--box); border-radius: 6px; } svg text { fill: var(--text); font: 11px system-ui, sans-serif; }
svg .title { font-size: 13px; font-weight: 600; } svg .tick, svg .label, svg .key { fill: var(--faint); }
svg .grid { stroke: var(--line); stroke-width: 1; } svg polyline { fill: none; stroke-width: 1.8; stroke-linejoin: round; } svg line { stroke-width: 2.5; }
.s0 { stroke: var(--c0); } .s1 { stroke: var(--c1); } .s2 { stroke: var(--c2); } .s3 { stroke: var(--c3); } .s4 { stroke: var(--c4); }
.s5 { stroke: var(--c5); } .s6 { stroke: var(--c6); } .s7 { stroke: var(--c7); }
)css";

}  // namespace

std::string html_page(const std::string& title, const std::string& body) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/><title>" +
         escape_html(title) + "</title><style>" + kStyle + "</style></head><body>\n<h1>" + escape_html(title) +
         "</h1>" + body + "\n</body></html>\n";
}

std::string html_row(const std::vector<std::string>& cells, const char* tag) {
  std::string html = "<tr>";
  for (const std::string& cell : cells) html += "<" + std::string(tag) + ">" + escape_html(cell) + "</" + tag + ">";
  return html + "</tr>";
}

}  // namespace kerf::load
