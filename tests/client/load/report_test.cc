#include "client/load/report.h"

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "client/load/metrics_text.h"
#include "client/load/svg_plot.h"

namespace kerf::load {
namespace {

using testing::HasSubstr;

// Returns the report of a run that has something of everything.
Report sample_report() {
  Report report;
  report.plan.sheets = 5;
  report.server_version = "1.2.3 <test> & \"more\"";
  report.server_workers = 2;
  report.processors = 2;
  report.measured_s = 10.0;
  report.window_s = 10.0;
  report.integrator = "explicit";
  report.refusals["OVERLOADED"] = 2;
  report.first_refusal = "running sheets need 2.10 of 2 workers";
  report.sheets = {{"sheets/load-0", "RUNNING", 600, 3, 0.0, 1.0},
                   {"sheets/load-1", "RUNNING", 450, 44, 2.5, 0.75},
                   {"sheets/load-2", "SLEEPING", 0, 0, 0.0, 0.0}};
  ReaderTotals& viewers = report.readers[0];
  viewers.readers = 2;
  viewers.frames = 1'200;
  viewers.bytes = 3'000'000;
  viewers.skipped = 17;
  for (int i = 1; i <= 1'000; ++i) viewers.age_us.add(i * 100);
  report.readers[2].readers = 1;
  report.readers[2].ends["TOO_SLOW"] = 1;
  report.cuts.sent = 20;
  report.cuts.applied = 19;
  report.cuts.missed = 1;
  report.cuts.reply_us.add(8'000, 20);
  report.cuts.reply_ticks.add(1, 19);
  report.cuts.seen_us.add(25'000, 18);
  report.cuts.seen_without = 1;
  report.control_us.add(100, 600);
  report.errors["CreateCut QUEUE_FULL"] = 4;
  report.stretches.resize(Recorder::kStretches);
  report.stretches[3].frames = 10;
  report.stretches[3].bytes = 25'000;
  report.stretches[3].age_us.add(5'000, 10);
  for (int i = 0; i <= 10; ++i) {
    Probe probe;
    probe.time = std::chrono::seconds(i);
    probe.ticks = 105 * i;
    probe.overruns = 4 * i;
    probe.load = 1.05;
    probe.server = ProcessUsage{1.5 * i, 100'000'000 + 1'000'000 * i};
    probe.client.cpu_s = 1.6 * i;
    report.probes.push_back(probe);
  }
  return report;
}

TEST(Report, SumsUp) {
  const Report report = sample_report();
  const Pace pace = pace_of(report);
  EXPECT_EQ(pace.running, 2);  // what sleeps has no pace
  EXPECT_EQ(pace.least, 0.75);
  EXPECT_EQ(pace.most, 1.0);
  EXPECT_EQ(pace.slipped, 1);
  EXPECT_EQ(ticks_of(report), 1'050);
  EXPECT_EQ(overruns_of(report), 47);
  EXPECT_EQ(num_errors(report), 4);
  EXPECT_DOUBLE_EQ(server_cores(report), 1.5);
  EXPECT_DOUBLE_EQ(client_cores(report), 1.6);
  EXPECT_EQ(latencies(report).back().us, &report.control_us);
}

TEST(Report, WarnsOfWhatSpoilsIt) {
  Report report = sample_report();
  EXPECT_THAT(warnings(report), testing::ElementsAre(HasSubstr("1.60 of 2 processors"), HasSubstr("without it")));
  report.control_us.add(30'000, 60);
  report.interrupted = true;
  report.cuts.seen_without = 0;
  for (Probe& probe : report.probes) probe.client.cpu_s = 0.0;
  EXPECT_THAT(warnings(report), testing::ElementsAre(HasSubstr("interrupted"), HasSubstr("30.0 ms late")));
  report.readers[2].readers = 3;
  EXPECT_THAT(warnings(report), testing::Contains(HasSubstr("2 of 3 stalled readers")));
}

TEST(Report, ReadersThatGotNothingAreErrors) {
  Report report = sample_report();
  report.plan.viewers = 5;
  report.plan.slow_readers = 2;
  report.readers[0].ends["UNAVAILABLE"] = 2;  // of five, two of which had frames
  report.readers[0].ended_without = 1;
  EXPECT_EQ(num_errors(report), 4 + 2 + 2 + 2);
  EXPECT_EQ(errors_of(report)["viewers ended: UNAVAILABLE"], 2);
  EXPECT_EQ(errors_of(report)["viewers without a frame"], 2);
  EXPECT_EQ(errors_of(report)["slow readers without a frame"], 2);
  EXPECT_FALSE(nobody_joined(report));
  for (const char* expected : {"3 of 5 viewers never", "2 viewers ended", "2 of 2 slow readers never"}) {
    EXPECT_THAT(warnings(report), testing::Contains(HasSubstr(expected)));
  }
  EXPECT_THAT(to_text(report), HasSubstr("errors     10"));
  EXPECT_THAT(to_html(report), HasSubstr("viewers without a frame"));
  report.readers = {};
  EXPECT_TRUE(nobody_joined(report));
  report.plan.viewers = report.plan.slow_readers = 0;
  EXPECT_FALSE(nobody_joined(report)) << "nobody was asked for";
}

// Ten seconds of which one had frames: elsewhere the line is at the bottom, and does not lead past the stall.
TEST(Report, AStallIsNoBytes) {
  const std::string html = to_html(sample_report());
  const std::size_t plot = html.find("Bytes to viewers");
  ASSERT_NE(plot, std::string::npos);
  const std::size_t points = html.find("points=\"", plot);
  const std::string line = html.substr(points, html.find("/>", points) - points);
  EXPECT_EQ(std::count(line.begin(), line.end(), ','), 40) << line;
  EXPECT_GT(std::count(line.begin(), line.end(), ' '), 30);
}

TEST(Report, TextHasTheNumbers) {
  const std::string text = to_text(sample_report());
  for (const char* expected : {"3 of 5", "OVERLOADED", "running sheets need 2.10", "1050, 47 after", "least 0.750",
                               "60.00 frames/s", "150.0 kB/s", "17 ticks skipped", "1: TOO_SLOW", "20 sent, 19 applied",
                               "4: CreateCut QUEUE_FULL", "a thread that only sleeps", "1.500 cores"}) {
    EXPECT_THAT(text, HasSubstr(expected));
  }
}

TEST(Report, JsonHasTheNumbers) {
  const nlohmann::json json = nlohmann::json::parse(to_json(sample_report()));
  EXPECT_EQ(json["sheets"]["made"], 3);
  EXPECT_EQ(json["sheets"]["refusals"]["OVERLOADED"], 2);
  EXPECT_EQ(json["sheets"]["real_time_factor"]["least"], 0.75);
  EXPECT_EQ(json["readers"]["viewers"]["frames"], 1'200);
  EXPECT_NEAR(json["readers"]["viewers"]["age_us"]["p50"].get<double>(), 50'000.0, 400.0);
  EXPECT_EQ(json["readers"]["stalled readers"]["ends"]["TOO_SLOW"], 1);
  EXPECT_EQ(json["cuts"]["seen_without"], 1);
  EXPECT_EQ(json["probes"].size(), 11U);
  EXPECT_EQ(json["server_cores"], 1.5);
  for (const char* name : {"image_width", "image_height", "keep_cuts", "prefix", "http"}) {
    EXPECT_TRUE(json["plan"].contains(name)) << name;
  }
}

TEST(Report, HtmlParsesNeedsNothingElseAndHasTheNumbers) {
  const std::string html = to_html(sample_report());
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_string(html.c_str(), pugi::parse_default | pugi::parse_doctype);
  ASSERT_TRUE(parsed) << parsed.description() << " at " << html.substr(static_cast<std::size_t>(parsed.offset), 80);
  EXPECT_EQ(document.select_nodes("//svg").size(), 7U);
  EXPECT_GT(document.select_nodes("//svg/polyline[@points]").size(), 8U);
  for (const char* outside : {"src=", "href=", "url(", "@import", "<script"}) {
    EXPECT_EQ(html.find(outside), std::string::npos) << outside;
  }
  for (const char* expected :
       {"3 of 5", "1050", "0.750 / 0.750", "1.2.3 &lt;test&gt; &amp; &quot;more&quot;", "60.0 Hz", "19 of 20",
        "1 TOO_SLOW", "CreateCut QUEUE_FULL", "running sheets need 2.10"}) {
    EXPECT_THAT(html, HasSubstr(expected));
  }
}

TEST(Report, OfNothingIsStillAReport) {
  Report report;
  report.plan.viewers = 0;
  report.probes.resize(1);
  report.stretches.resize(Recorder::kStretches);
  pugi::xml_document document;
  EXPECT_TRUE(document.load_string(to_html(report).c_str(), pugi::parse_default | pugi::parse_doctype));
  EXPECT_THAT(to_html(report), HasSubstr("nothing was measured"));
  EXPECT_THAT(to_text(report), HasSubstr("errors     0"));
  EXPECT_TRUE(nlohmann::json::parse(to_json(report))["server_cores"].is_null());
}

TEST(SvgPlot, PutsValuesWhereTheAxesHaveThem) {
  const std::string svg = svg_plot("T", {"x", false, {}}, {"y", false, {}}, {{"a", {{0.0, 0.0}, {10.0, 50.0}}}});
  EXPECT_THAT(svg, HasSubstr("points=\"64,220 624,34 \""));  // the corners of the plot
  const std::string log =
      svg_plot("T", {"x", true, {}}, {"y", true, {}}, {{"a", {{1.0, 1.0}, {0.0, 5.0}, {100.0, 10.0}}}});
  EXPECT_THAT(log, HasSubstr("points=\"64,220 624,34 \""));  // what has no logarithm is left out
}

TEST(MetricsText, HasWhatIsAskedFor) {
  const std::string page =
      "# HELP process_cpu_seconds_total x\nprocess_cpu_seconds_total 12.5\nprocess_resident_memory_bytes 1.5e+08\n"
      "kerf_a{b=\"c\"} 4\nkerf_ab 7\n";
  const std::optional<ProcessUsage> usage = usage_in(page);
  ASSERT_TRUE(usage);
  EXPECT_EQ(usage->cpu_s, 12.5);
  EXPECT_EQ(usage->resident_bytes, 150'000'000);
  EXPECT_EQ(metric_in(page, "kerf_ab"), 7.0);
  EXPECT_EQ(metric_in(page, "kerf_a{b=\"c\"}"), 4.0);
  EXPECT_FALSE(metric_in(page, "kerf_a"));
  EXPECT_FALSE(usage_in("nothing"));
}

}  // namespace
}  // namespace kerf::load
