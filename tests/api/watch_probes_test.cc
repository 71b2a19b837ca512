// Probes of a Watch: the values that come with frames.

#include <cmath>
#include <future>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "tests/api/fixture.h"
#include "tests/api/viewer.h"

namespace kerf::api {
namespace {

// Keeps the values of each frame.
struct ProbeViewer : Viewer {
  using Viewer::Viewer;

  void start_with(const v1::WatchStart& start) {
    v1::WatchRequest request;
    *request.mutable_start() = start;
    session().on_request(request);
  }
  // Takes and acknowledges what there is.
  bool drain() {
    bool any = false;
    while (const auto response = next()) {
      if (!response->has_frame()) continue;
      const v1::Frame& frame = response->frame();
      EXPECT_EQ(mirror.apply(frame), std::nullopt);
      if (frame.probe_columns_size() > 0) columns.assign(frame.probe_columns().begin(), frame.probe_columns().end());
      values.assign(frame.probe_values().begin(), frame.probe_values().end());
      EXPECT_EQ(values.size(), columns.size()) << "frame of tick " << frame.tick();
      acknowledge(mirror.sequence);
      any = true;
    }
    return any;
  }
  [[nodiscard]] double value(const std::string& column) const {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i] == column) return values.at(i);
    }
    ADD_FAILURE() << "no column " << column;
    return 0.0;
  }

  std::vector<std::string> columns;
  std::vector<double> values;
};

v1::Probe probe_of(const std::string& name, v1::Probe::Quantity quantity) {
  v1::Probe probe;
  probe.set_name(name);
  probe.set_quantity(quantity);
  return probe;
}

v1::Probe probe_at(const std::string& name, v1::Probe::Quantity quantity, double x, double y) {
  v1::Probe probe = probe_of(name, quantity);
  probe.add_points()->set_x(x);
  probe.mutable_points(0)->set_y(y);
  return probe;
}

// Probes of every quantity, around a slit from the left at y = 0.45.
v1::WatchStart start_of(const std::string& name) {
  v1::WatchStart start;
  start.set_name(name);
  for (int q = v1::Probe::DISPLACEMENT; q <= v1::Probe::INTERSECTIONS; ++q) {
    const auto quantity = static_cast<v1::Probe::Quantity>(q);
    const std::string id = "p" + std::to_string(q);
    if (quantity == v1::Probe::REACTION) {
      v1::Probe& probe = *start.add_probes();
      probe = probe_of(id, quantity);
      probe.mutable_region()->set_edge(v1::Region::TOP);
    } else if (q >= v1::Probe::ENERGY && quantity != v1::Probe::OPENING) {
      *start.add_probes() = probe_of(id, quantity);
    } else {
      *start.add_probes() = probe_at(id, quantity, 0.2, 0.45);
    }
  }
  return start;
}

class WatchProbesTest : public ApiTest {
 protected:
  // Measures a paused sheet by an analysis without ticks.
  v1::Table analysed(const v1::WatchStart& start) {
    v1::AnalyzeSheetRequest request;
    request.set_name(start.name());
    request.mutable_analysis()->mutable_dynamic();
    *request.mutable_probes() = start.probes();
    std::promise<Result<v1::AnalyzeSheetResponse>> promise;
    api_->analyze_sheet(request, [&](Result<v1::AnalyzeSheetResponse> reply) { promise.set_value(std::move(reply)); },
                        {});
    return promise.get_future().get().value().tables(0);
  }
  void post(const std::string& method, const std::string& json) {
    const auto done = call_json("/kerf.v1." + method, json);
    ASSERT_TRUE(done.ok()) << done.error().message;
  }
  // Takes frames until there are no more, whatever the sheet must publish for that.
  void drain(ProbeViewer& viewer) {
    do {
      host_->wait_idle();
    } while (viewer.drain());
  }
};

TEST_F(WatchProbesTest, EqualAnAnalysisThroughTicksCutsUndoSavedStatesAndReset) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const v1::WatchStart start = start_of("sheets/a");
  ProbeViewer viewer(*api_);
  viewer.start_with(start);
  int compared = 0;
  const auto compare = [&](const char* when) {
    drain(viewer);
    const v1::Table table = analysed(start);
    ASSERT_EQ(table.columns_size(), 1 + static_cast<int>(viewer.columns.size())) << when;
    for (std::size_t i = 0; i < viewer.columns.size(); ++i) {
      const int column = static_cast<int>(i) + 1;
      EXPECT_EQ(viewer.columns[i], table.columns(column));
      const double expected = table.rows(0).values(column);
      if (std::isnan(expected)) {
        EXPECT_TRUE(std::isnan(viewer.values[i])) << viewer.columns[i] << " " << when;
      } else {
        EXPECT_EQ(viewer.values[i], expected) << viewer.columns[i] << " " << when;
      }
    }
    ++compared;
  };
  compare("at first");
  EXPECT_TRUE(std::isnan(viewer.value("p11.normal"))) << "no cut to open yet";
  post("SheetService/StepSheet", R"({"name":"sheets/a","ticks":7})");
  compare("after ticks");
  post("SheetService/SaveState", R"({"parent":"sheets/a","state_id":"before"})");
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  compare("after a cut");
  EXPECT_FALSE(std::isnan(viewer.value("p11.normal")));
  post("SheetService/StepSheet", R"({"name":"sheets/a","ticks":5})");
  compare("after ticks of the cut sheet");
  post("CutService/UndoCut", R"({"parent":"sheets/a"})");
  compare("after undo");
  EXPECT_TRUE(std::isnan(viewer.value("p11.normal")));
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.3)).ok());
  post("SheetService/RestoreState", R"({"name":"sheets/a/states/before"})");
  compare("after a restored state");
  post("SheetService/ResetSheet", R"({"name":"sheets/a"})");
  compare("after reset");
  EXPECT_EQ(compared, 7);
}

TEST_F(WatchProbesTest, ARunningSheetIsMeasuredAtTheTickOfEachFrame) {
  ASSERT_TRUE(create_sheet("a", false).ok());
  ProbeViewer viewer(*api_);
  v1::WatchStart start;
  start.set_name("sheets/a");
  *start.add_probes() = probe_at("tip", v1::Probe::POSITION, 0.5, 0.0);
  viewer.start_with(start);
  int frames = 0;
  for (int tick = 0; tick < 50; ++tick) {
    run_for(kTick);
    if (!viewer.drain()) continue;
    ++frames;
    // Vertex 3 is the middle of the lowest row of seven.
    const auto shown = viewer.mirror.position(3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_NEAR(viewer.values.at(axis), shown[axis],
                  (viewer.mirror.box_max[axis] - viewer.mirror.box_min[axis]) / 1e5);
    }
  }
  EXPECT_GT(frames, 40);
}

TEST_F(WatchProbesTest, AVertexThatUndoTakesAwayIsNotMeasured) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  ASSERT_TRUE(call(&Api::create_cut, cut_request("sheets/a", 0.45)).ok());
  const std::int32_t last = get_sheet("sheets/a").num_vertices() - 1;
  ProbeViewer viewer(*api_);
  v1::WatchStart start;
  start.set_name("sheets/a");
  v1::Probe& probe = *start.add_probes() = probe_of("new", v1::Probe::POSITION);
  probe.mutable_region()->mutable_vertices()->add_vertices(last);
  viewer.start_with(start);
  drain(viewer);
  EXPECT_FALSE(std::isnan(viewer.value("new.x")));
  post("CutService/UndoCut", R"({"parent":"sheets/a"})");
  drain(viewer);
  EXPECT_TRUE(std::isnan(viewer.value("new.x")));
}

TEST_F(WatchProbesTest, RefusesProbesThatCannotBeMeasured) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const auto refused = [&](const v1::WatchStart& start) {
    ProbeViewer viewer(*api_);
    viewer.start_with(start);
    host_->wait_idle();
    const bool has_frame = viewer.next().has_value();
    const auto error = viewer.session().failure();
    EXPECT_NE(has_frame, error.has_value());
    return error ? error->reason + " " + error->field : "";
  };
  v1::WatchStart start;
  start.set_name("sheets/a");
  *start.add_probes() = probe_at("far", v1::Probe::POSITION, 7.0, 0.5);
  EXPECT_EQ(refused(start), "POINT_OUTSIDE start.probes[0].points[0]");
  start.mutable_probes(0)->clear_points();
  EXPECT_EQ(refused(start), "PLACE_MISSING start.probes[0].points");
  *start.mutable_probes(0) = probe_at("many", v1::Probe::POSITION, 0.5, 0.5);
  for (int i = 0; i < 341; ++i) *start.mutable_probes(0)->add_points() = start.probes(0).points(0);
  EXPECT_EQ(refused(start), "TOO_MANY_VALUES start.probes");
  start.mutable_probes(0)->mutable_points()->DeleteSubrange(341, 1);
  EXPECT_EQ(refused(start), "") << "1,023 values";
  start.mutable_probes(0)->set_reduce(v1::Probe::MEAN);
  *start.add_probes() = start.probes(0);
  *start.add_probes() = start.probes(0);
  *start.add_probes() = start.probes(0);
  for (int i = 1; i < 4; ++i) start.mutable_probes(i)->set_name("many" + std::to_string(i));
  EXPECT_EQ(refused(start), "TOO_MANY_POINTS start.probes");
  start.clear_probes();
  *start.add_probes() = probe_of("all", v1::Probe::ENERGY);
  start.set_name("sheets/b");
  EXPECT_EQ(refused(start), "SHEET_NOT_FOUND start.name");
}

}  // namespace
}  // namespace kerf::api
