#include "client/load/metrics.h"

#include <algorithm>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "client/load/comparison.h"
#include "client/load/cut_shape.h"
#include "client/load/html_page.h"
#include "client/load/report.h"

namespace kerf::load {
namespace {

using testing::HasSubstr;
using Verdict = Judgement::Verdict;

// Returns a report of a run of 4 s: two viewers, and `cuts` cuts answered after 1, 2, ... ms.
Report run_of(int cuts) {
  Report report;
  report.plan.duration_s = report.measured_s = report.window_s = 4.0;
  report.plan.viewers = report.readers[0].readers = 2;
  report.readers[0].frames = 480;
  report.sheets = {{"sheets/load-0", "RUNNING", 240, 12, 0.0, 1.0}};
  report.cuts.sent = cuts;
  report.stretches.resize(Recorder::kStretches);
  for (int i = 1; i <= cuts; ++i) report.cuts.reply_us.add(1000 * i);
  report.stretches[0].cut_us.add(7000, 3);
  report.stretches[0].errors = 2;
  report.stretches[29].frames = 10;  // The last of the first second.
  report.stretches[30].frames = 20;
  for (int i = 0; i <= 4; ++i) {
    Probe probe;
    probe.time = std::chrono::seconds(i);
    probe.ticks = 60 * i;
    probe.overruns = 3 * i;
    probe.server = ProcessUsage{0.5 * i, 200'000'000};
    report.probes.push_back(probe);
  }
  return report;
}

std::string wrong_condition(const std::string& text) {
  const Result<Condition> condition = parse_condition(text);
  return condition.ok() ? "" : condition.error().reason + ": " + condition.error().message;
}

Verdict verdict(const std::string& condition, const Report& of) {
  Report report = of;
  report.plan.fail_if = {*parse_condition(condition)};
  return judge(report)[0].verdict;
}

TEST(Condition, HasAMetricARelationAndALimit) {
  const Condition condition = *parse_condition("  cut_p99 >= 0.05 s ");
  EXPECT_EQ(condition.text, "cut_p99 >= 0.05 s");
  EXPECT_EQ(condition.metric, "cut_p99");
  EXPECT_EQ(condition.limit, 50.0);
  EXPECT_TRUE(condition.holds(50.0));
  EXPECT_FALSE(condition.holds(49.9));
  EXPECT_FALSE(parse_condition("errors>0")->holds(0.0));
  EXPECT_TRUE(parse_condition("errors<=0")->holds(0.0));
  EXPECT_FALSE(parse_condition("real_time_least<0.9")->holds(0.9));
  EXPECT_EQ(parse_condition("server_memory>1GB")->limit, 1000.0);
}

TEST(Condition, ThatIsMalformedSaysWhatIsWrong) {
  EXPECT_THAT(wrong_condition("cut_p98>50ms"),
              HasSubstr("UNKNOWN_METRIC: \"cut_p98>50ms\": there is no metric cut_p98"));
  EXPECT_EQ(metric_word(" cut_p98>50ms"), "cut_p98");
  EXPECT_THAT(wrong_condition("cut_p99>50"),
              HasSubstr("BAD_UNIT: \"cut_p99>50\": cut_p99 takes a number with one of the units ms, "
                        "s, us, and none is given"));
  EXPECT_THAT(wrong_condition("cut_p99>50kB"), HasSubstr("not \"kB\""));
  EXPECT_THAT(wrong_condition("errors>1ms"), HasSubstr("errors takes a number without a unit, not \"ms\""));
  for (const char* text : {"", "cut_p99", ">5ms", "cut_p99=5ms", "cut_p99>ms", "cut_p99>nanms", "cut_p99>>5ms"}) {
    EXPECT_THAT(wrong_condition(text), HasSubstr("BAD_CONDITION")) << text;
  }
}

TEST(Condition, APercentileOfTooFewValuesIsUndecided) {
  EXPECT_EQ(verdict("cut_p99>50ms", run_of(100)), Verdict::kFailed);
  EXPECT_EQ(verdict("cut_p99>200ms", run_of(100)), Verdict::kPassed);
  EXPECT_EQ(verdict("cut_p99>50ms", run_of(99)), Verdict::kUndecided);
  EXPECT_EQ(verdict("cut_p99<50ms", run_of(99)), Verdict::kUndecided) << "It would hold or not by chance.";
  EXPECT_EQ(verdict("cut_max>50ms", run_of(99)), Verdict::kFailed);
  EXPECT_EQ(verdict("cut_max>50ms", run_of(0)), Verdict::kUndecided);
  EXPECT_EQ(verdict("client_cores>50", Report()), Verdict::kUndecided);
  EXPECT_EQ(verdict("overrun_share>4.9%", run_of(0)), Verdict::kFailed);
  EXPECT_EQ(verdict("frame_rate<60Hz", run_of(0)), Verdict::kPassed);
  Report few = run_of(99);
  few.plan.fail_if = {*parse_condition("cut_p99>50ms"), *parse_condition("cut_shown_p50>1ms")};
  EXPECT_EQ(describe(judge(few)[0]), "cut_p99>50ms: undecided, 99 ms of 99 values, where at least 100 are needed");
  EXPECT_EQ(describe(judge(few)[1]), "cut_shown_p50>1ms: undecided, nothing was measured");
  EXPECT_THAT(to_text(few), HasSubstr("cut_p99>50ms: undecided"));
  EXPECT_THAT(to_html(few), HasSubstr("cut_p99&gt;50ms: undecided"));
  EXPECT_EQ(nlohmann::json::parse(to_json(few))["fail_if"][0]["verdict"], "undecided");
}

TEST(Metrics, HaveNamesOfTheirOwnAndAreListed) {
  std::set<std::string> names;
  for (const Metric& metric : metrics()) EXPECT_TRUE(names.insert(metric.name).second) << metric.name;
  for (const char* name : {"cut_p99", "frame_age_p50", "real_time_least", "errors"}) EXPECT_EQ(names.count(name), 1U);
  const std::string list = list_of_metrics();
  for (const std::string& name : names) {
    const std::string family = name.substr(0, name.rfind('_'));
    EXPECT_TRUE(list.find("  " + name + " ") != std::string::npos ||
                list.find("  " + family + " ") != std::string::npos)
        << name;
  }
  EXPECT_EQ(values_needed(0.5), 2);
  EXPECT_EQ(values_needed(0.9), 10);
  EXPECT_EQ(values_needed(0.99), 100);
  EXPECT_EQ(values_needed(0.999), 1000);
}

TEST(Report, MarksPercentilesOfTooFewValues) {
  const std::string text = to_text(run_of(50));
  EXPECT_THAT(text, HasSubstr("25.09      45.05      50.00*     50.00*     50.00\n"));
  EXPECT_THAT(text, HasSubstr(kFewValues));
  EXPECT_THAT(to_html(run_of(50)), HasSubstr("<td>50.00 *</td>"));
  Report many = run_of(0);
  EXPECT_THAT(to_text(many), testing::Not(HasSubstr(kFewValues)));
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Csv, HasALineForEachSecond) {
  const std::vector<std::string> lines = lines_of(to_interval_csv(run_of(5)));
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_EQ(lines[1], "0,1,2,1,60,1,3,10,0,,,3,7,7,2,0.5");
  EXPECT_EQ(lines[2], "1,2,2,1,60,1,3,20,0,,,0,,,0,0.5");
  for (const std::string& line : lines) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), std::count(lines[0].begin(), lines[0].end(), ',')) << line;
  }
}

TEST(Csv, CountsWhatStagesHave) {
  Report report = run_of(5);
  report.plan.stages = *parse_stages("2s:2,2s:0");
  const std::vector<std::string> lines = lines_of(to_interval_csv(report));
  EXPECT_THAT(lines[1], testing::StartsWith("0,1,0.5,1,"));
  EXPECT_THAT(lines[2], testing::StartsWith("1,2,1.5,1,"));
  EXPECT_THAT(to_html(report), HasSubstr("Viewers of the stages"));
  EXPECT_THAT(to_html(run_of(5)), testing::Not(HasSubstr("of the stages")));
  EXPECT_EQ(reader_seconds(report, Role::kViewer), 4.0);
  EXPECT_EQ(find_metric("frame_rate")->figure(report).value, 120.0);
}

TEST(Csv, TheSummaryHasALineForEachMetric) {
  const std::vector<std::string> lines = lines_of(to_summary_csv(run_of(5)));
  EXPECT_EQ(lines.size(), metrics().size() + 1);
  EXPECT_THAT(lines, testing::Contains("cut_p50,3.007,ms,5,yes,\"request to reply of a cut, p50\""));
  EXPECT_THAT(lines, testing::Contains("cut_p99,5,ms,5,no,\"request to reply of a cut, p99\""));
  EXPECT_THAT(lines, testing::Contains(testing::StartsWith("frame_age_p50,,ms,0,no,")));
}

TEST(Comparison, ShowsBothReportsAndTheirRatio) {
  Report slower = run_of(50);
  slower.plan.cuts_per_second = 20.0;
  for (Probe& probe : slower.probes) probe.server->cpu_s *= 2.0;
  const Comparison comparison = *compare({"a.json", to_json(run_of(200))}, {"b.json", to_json(slower)});
  ASSERT_EQ(comparison.settings.size(), 1U);
  EXPECT_EQ(comparison.settings[0].name, "cuts_per_second");
  const auto named = [&](const std::string& name) {
    return *std::find_if(comparison.metrics.begin(), comparison.metrics.end(),
                         [&](const ComparedMetric& metric) { return metric.name == name; });
  };
  EXPECT_EQ(named("server_cores").ratio(), 2.0);
  EXPECT_EQ(named("cuts_sent").ratio(), 0.25);
  EXPECT_FALSE(named("cut_p99").enough);
  EXPECT_TRUE(named("cut_p90").enough);
  EXPECT_FALSE(named("errors").ratio()) << "Nothing has a ratio to 0.";
  const std::string text = to_text(comparison);
  EXPECT_THAT(text, HasSubstr("differs cuts_per_second: 0.0 and 20.0\n"));
  EXPECT_THAT(text, testing::ContainsRegex("\nserver_cores +0.5 +1 +2\n"));
  EXPECT_THAT(text, testing::ContainsRegex("\ncut_p99 +ms +[0-9.]+ +50 +[0-9.]+ \\*\n"));
  EXPECT_EQ(nlohmann::json::parse(to_json(comparison, {}))["metrics"]["server_cores"]["ratio"], 2.0);
  pugi::xml_document page;
  ASSERT_TRUE(page.load_string(to_html(comparison).c_str(), pugi::parse_default | pugi::parse_doctype));
  EXPECT_EQ(page.select_nodes("//td[@class='worse']").size(), 1U) << "The server's processors.";
  EXPECT_GT(page.select_nodes("//td[@class='better']").size(), 1U) << "Latencies of cuts.";
  EXPECT_GT(page.select_nodes("//svg/line").size(), 4U);
}

TEST(Comparison, IsJudgedByItsRatios) {
  Report slower = run_of(50);
  for (Probe& probe : slower.probes) probe.server->cpu_s *= 2.0;
  const Comparison comparison = *compare({"a.json", to_json(run_of(200))}, {"b.json", to_json(slower)});
  const auto judged = [&](const std::string& condition) {
    const Result<std::vector<Judgement>> found = judge(comparison, {*parse_condition(condition)});
    return found.ok() ? describe((*found)[0]) : found.error().reason;
  };
  EXPECT_EQ(judged("server_cores>1.5x"), "server_cores>1.5x: failed, 2x");
  EXPECT_EQ(judged("server_cores>2.5x"), "server_cores>2.5x: passed, 2x");
  EXPECT_THAT(judged("cut_p99>0.1x"), testing::ContainsRegex("undecided, 0.2[0-9]*x of too few values"));
  EXPECT_EQ(judged("errors>1x"), "errors>1x: undecided, there is no ratio");
  EXPECT_EQ(judged("image_age_p50>1x"), "image_age_p50>1x: undecided, there is no ratio");
  EXPECT_EQ(judged("cut_p99>50ms"), "NOT_A_RATIO");
  Plan plan;
  plan.fail_if = {*parse_condition("cut_p99>1.2x")};
  EXPECT_EQ(check(plan).error().reason, "NOT_A_COMPARISON");
}

TEST(Comparison, OfSomethingElseIsRefused) {
  const std::string good = to_json(run_of(1));
  for (const char* text : {"", "[]", "{}", "{\"metrics\": 3, \"plan\": {}}", "{\"metrics\": {}, \"plan\": 1}"}) {
    const Result<Comparison> comparison = compare({"a.json", good}, {"b.json", text});
    ASSERT_FALSE(comparison.ok()) << text;
    EXPECT_THAT(comparison.error().message, HasSubstr("b.json is no report"));
  }
}

TEST(HtmlPage, HasEachColourInBothThemes) {
  const std::string page = html_page("<T>", "");
  EXPECT_THAT(page, HasSubstr("<title>&lt;T&gt;</title>"));
  const std::size_t dark = page.find("prefers-color-scheme: dark");
  ASSERT_NE(dark, std::string::npos);
  const auto colours = [&](std::size_t from) {
    const std::string block = page.substr(page.find(":root", from), page.find('}', from) - page.find(":root", from));
    std::set<std::string> names;
    for (std::size_t at = block.find("--"); at != std::string::npos; at = block.find("--", at + 2)) {
      names.insert(block.substr(at, block.find(':', at) - at));
    }
    return names;
  };
  EXPECT_GT(colours(0).size(), 10U);
  EXPECT_EQ(colours(0), colours(dark));
}

TEST(CutShape, EachKindHasItsCurveWithinItsLength) {
  const CutPlace place{1.0, 2.0, 0.3, 0.1};
  EXPECT_EQ(cut_of(CutKind::kSlit, 0, place).curve().polyline().points_size(), 2);
  EXPECT_EQ(cut_of(CutKind::kCurve, 0, place).curve().bezier().points_size(), 4);
  EXPECT_EQ(cut_of(CutKind::kCircle, 0, place).curve().circle().radius_m(), 0.05);
  const v1::Polyline star = cut_of(CutKind::kStar, 0, place).curve().polyline();
  ASSERT_EQ(star.points_size(), 11);
  EXPECT_EQ(star.points(0).x(), star.points(10).x());
  for (const v1::Vec2& point : star.points()) EXPECT_LE(std::hypot(point.x() - 1.0, point.y() - 2.0), 0.05 + 1e-12);
  const v1::Cut drawing = cut_of(CutKind::kDrawing, 0, place);
  pugi::xml_document svg;
  EXPECT_TRUE(svg.load_string(drawing.curve().svg().text().c_str()));
  EXPECT_NEAR(drawing.fit().max().x() - drawing.fit().min().x(), 0.1, 1e-12);
  std::set<v1::Curve::KindCase> kinds;
  for (int k = 0; k < 5; ++k) kinds.insert(cut_of(CutKind::kMixed, k, place).curve().kind_case());
  EXPECT_EQ(kinds.size(), 4U) << "A slit and a star are both lines.";
  for (const auto& [name, kind] : kCutKinds) EXPECT_EQ(name_of(kind), name);
}

}  // namespace
}  // namespace kerf::load
