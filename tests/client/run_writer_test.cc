// Runs that NumPy reads: what it finds in them is compared with what the frames showed.

#include "client/cpp/run_writer.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/cpp/server.h"
#include "tests/support/temporary_folder.h"
#include "tests/ws/running_server.h"

namespace kerf::client {
namespace {

class RunWriterTest : public testing::Test {
 protected:
  void SetUp() override {
    running_ = ws_test::start_server();
    ASSERT_NE(running_, nullptr);
    server_ = std::make_unique<Server>(running_->grpc_address());
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  // Returns the output of Debian's Python, with NumPy and the file as `run`.
  static std::string numpy(const std::string& file, const std::string& expression) {
    const std::string command =
        "/usr/bin/python3 -c \"import numpy, json; run = numpy.load('" + file + "'); print(" + expression + ")\" 2>&1";
    FILE* pipe = popen(command.c_str(), "r");
    std::string printed;
    for (int byte = std::fgetc(pipe); byte != EOF; byte = std::fgetc(pipe)) printed += static_cast<char>(byte);
    pclose(pipe);
    return printed;
  }

  std::unique_ptr<app::Server> running_;
  std::unique_ptr<Server> server_;
  test::TemporaryFolder folder_;
};

TEST_F(RunWriterTest, NumPyReadsWhatTheFramesShowed) {
  Sheet sheet = server_->create(grid_scene(8, 8, 1.0, 1.0), {"run", true, ""}).value();
  const auto writer = RunWriter::open(path("run.npz")).value();
  double sum = 0.0;
  std::size_t num_triangles = 0;
  // Each frame is of the tick that was asked for: the sheet is paused.
  const auto on_frame = [&](const v1::Frame&, const Mirror& mirror) {
    EXPECT_TRUE(writer->add(mirror).ok());
    for (std::int32_t vertex = 0; vertex < mirror.num_vertices(); ++vertex) sum += mirror.position(vertex)[2];
    num_triangles = 0;
    for (const auto& triangle : mirror.triangles()) num_triangles += triangle[0] >= 0 ? 1 : 0;
    if (mirror.tick() == 2 && mirror.num_pieces() == 1) {
      EXPECT_EQ(sheet.cut(polyline({{0.5, -1}, {0.5, 2}})).value().status(), v1::CutResult::APPLIED);
    } else if (mirror.tick() < 4) {
      EXPECT_TRUE(sheet.step(2).ok());
    }
    return mirror.tick() < 4;
  };
  ASSERT_TRUE(sheet.watch(on_frame, {.strains = true}).ok());
  EXPECT_FALSE(std::filesystem::exists(path("run.npz"))) << "not before it is whole";
  ASSERT_TRUE(writer->close().ok());
  ASSERT_TRUE(writer->close().ok());
  EXPECT_FALSE(std::filesystem::exists(path("run.npz.part")));

  EXPECT_EQ(numpy(path("run.npz"), "run['ticks'].tolist()"), "[0, 2, 2, 4]\n");
  EXPECT_EQ(numpy(path("run.npz"), "json.loads(bytes(run['meta']))"),
            "{'format': 'kerf-run', 'version': 1, 'chunks': [{'topology': 0, 'chunk': 0, 'frames': 2}, "
            "{'topology': 1, 'chunk': 0, 'frames': 2}], 'topology_versions': [1, 2]}\n");
  EXPECT_EQ(numpy(path("run.npz"),
                  "run['positions_0_0'].shape, run['strains_0_0'].shape, run['triangles_0'].shape, "
                  "run['pieces_0'].shape, run['material_positions_0'].shape"),
            "(2, 64, 3) (2, 64) (98, 3) (98,) (64, 2)\n");
  EXPECT_EQ(numpy(path("run.npz"), "run['triangles_1'].shape[0], sorted(set(run['pieces_1'].tolist()))"),
            std::to_string(num_triangles) + " [0, 1]\n");
  const std::string of_all = "sum(run['positions_%d_0' % k][:, :, 2].astype('f8').sum() for k in (0, 1))";
  EXPECT_NEAR(std::stod(numpy(path("run.npz"), of_all)), sum, 1e-5 * std::abs(sum));
}

TEST_F(RunWriterTest, AnotherTopologyOfAnEqualVersionIsWrittenToo) {
  Sheet sheet = server_->create(grid_scene(8, 8, 1.0, 1.0), {"states", true, ""}).value();
  ASSERT_TRUE(sheet.save_state("whole").ok());
  ASSERT_TRUE(sheet.step(2).ok());
  ASSERT_TRUE(sheet.cut(polyline({{0.5, -1}, {0.5, 2}})).ok());
  ASSERT_TRUE(sheet.save_state("cut").ok());
  ASSERT_TRUE(sheet.restore_state("whole").ok());
  ASSERT_TRUE(sheet.cut(circle({0.5, 0.5}, 0.3)).ok());
  const auto writer = RunWriter::open(path("states.npz")).value();
  std::vector<std::int32_t> versions;
  const auto on_frame = [&](const v1::Frame&, const Mirror& mirror) {
    EXPECT_TRUE(writer->add(mirror).ok());
    versions.push_back(mirror.topology_version());
    return versions.size() < 2 && sheet.restore_state("cut").ok();
  };
  ASSERT_TRUE(sheet.watch(on_frame).ok());
  ASSERT_TRUE(writer->close().ok());
  EXPECT_EQ(versions, (std::vector<std::int32_t>{2, 2}));
  EXPECT_EQ(numpy(path("states.npz"), "run['ticks'].tolist(), 'triangles_1' in run.files"), "[0, 2] True\n");
}

TEST_F(RunWriterTest, LongRunsAreWrittenAsTheyCome) {
  Sheet sheet = server_->create(grid_scene(200, 200, 1.0, 1.0), {"long", true, ""}).value();
  const auto writer = RunWriter::open(path("long.npz")).value();
  constexpr int kFrames = 40;  // of 480,000 bytes
  ASSERT_TRUE(sheet
                  .watch([&](const v1::Frame&, const Mirror& mirror) {
                    while (writer->num_frames() < kFrames) EXPECT_TRUE(writer->add(mirror).ok());
                    return false;
                  })
                  .ok());
  EXPECT_GT(std::filesystem::file_size(path("long.npz.part")), std::size_t{16} << 20);
  ASSERT_TRUE(writer->close().ok());
  EXPECT_EQ(numpy(path("long.npz"), "[run[name].shape[0] for name in run.files if name.startswith('positions')]"),
            "[18, 18, 4]\n");
}

TEST_F(RunWriterTest, LeavesAloneWhatItDoesNotFinish) {
  std::ofstream(path("kept.npz")) << "of before";
  { const auto writer = RunWriter::open(path("kept.npz")).value(); }
  std::string kept;
  std::getline(std::ifstream(path("kept.npz")), kept);
  EXPECT_EQ(kept, "of before");
  EXPECT_FALSE(std::filesystem::exists(path("kept.npz.part")));

  std::filesystem::create_symlink("/dev/full", path("device"));
  EXPECT_EQ(RunWriter::open(path("device")).failure().reason, "FILE_NOT_WRITTEN") << "a device is no file";

  const auto nowhere = RunWriter::open(path("nowhere/run.npz"));
  ASSERT_FALSE(nowhere.ok());
  EXPECT_EQ(nowhere.failure().reason, "FILE_NOT_WRITTEN");
  EXPECT_NE(nowhere.failure().message.find("No such file"), std::string::npos) << nowhere.failure().message;
}

TEST_F(RunWriterTest, FramesOfAnEarlierTickAreRefused) {
  Sheet late = server_->create(grid_scene(3, 3, 1.0, 1.0), {"late", true, ""}).value();
  ASSERT_TRUE(late.step(5).ok());
  Sheet early = server_->create(grid_scene(3, 3, 1.0, 1.0), {"early", true, ""}).value();
  const auto writer = RunWriter::open(path("order.npz")).value();
  const auto added = [&](Sheet& sheet) {
    Result<Done> result = Done{};
    const auto add = [&](const v1::Frame&, const Mirror& mirror) {
      result = writer->add(mirror);
      return false;
    };
    EXPECT_TRUE(sheet.watch(add).ok());
    return result;
  };
  EXPECT_TRUE(added(late).ok());
  const Result<Done> refused = added(early);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.failure().reason, "FRAME_ORDER");
  EXPECT_TRUE(added(late).ok());
  EXPECT_EQ(writer->num_frames(), 2);
}

}  // namespace
}  // namespace kerf::client
