#include "server/service/offline/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/service/drawing/inflate.h"
#include "tests/support/memory_disk.h"

namespace kerf::offline {
namespace {

constexpr const char* kScene = R"({"sheet_id": "cloth", "obj": {"file": "cloth.obj"}})";
constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

TEST(OfflineScene, NamesFilesRelativeToItself) {
  test::MemoryDisk disk;
  ASSERT_TRUE(disk.write_file("scenes/a.json", kScene).ok());
  ASSERT_TRUE(disk.write_file("scenes/cloth.obj", kTriangle).ok());
  const Result<scene::SheetConfig> config = read_scene(disk, "scenes/a.json");
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(to_message(*config).sheet_id(), "cloth");
  EXPECT_EQ(to_message(*config).obj().text(), kTriangle);
}

TEST(OfflineScene, ThatIsMissingOrNamesAMissingFileIsRefused) {
  test::MemoryDisk disk;
  EXPECT_EQ(read_scene(disk, "a.json").error().reason, "FILE_NOT_FOUND");
  ASSERT_TRUE(disk.write_file("a.json", kScene).ok());
  EXPECT_EQ(read_scene(disk, "a.json").error().reason, "FILE_NOT_FOUND");
  ASSERT_TRUE(disk.write_file("a.json", "{").ok());
  EXPECT_EQ(read_scene(disk, "a.json").error().reason, "JSON_SYNTAX");
}

TEST(OfflineOverrides, ReplaceOnlyWhatTheyName) {
  scene::SheetConfig config;
  config.integrator.precision = scene::Precision::kMixed;
  ASSERT_TRUE(apply({}, config).ok());
  EXPECT_EQ(config.integrator.kind, scene::SheetConfig().integrator.kind);
  ASSERT_TRUE(apply({"bdf2", "", "direct", "real-time", "green"}, config).ok());
  EXPECT_EQ(config.integrator.kind, scene::IntegratorKind::kBdf2);
  EXPECT_EQ(config.integrator.precision, scene::Precision::kMixed);
  EXPECT_EQ(config.integrator.solver, scene::LinearSolverKind::kDirect);
  EXPECT_EQ(config.fidelity, scene::Fidelity::kRealTime);
  EXPECT_EQ(config.membrane_law, fem::MembraneLaw::kGreen);
}

TEST(OfflineOverrides, KnowEveryNameThatTheyList) {
  for (const std::string& name : integrator_names()) EXPECT_TRUE(integrator_message({.integrator = name}).ok()) << name;
  for (const std::string& name : solver_names()) EXPECT_TRUE(integrator_message({.solver = name}).ok()) << name;
  EXPECT_EQ(integrator_message({.integrator = "tr-bdf2"})->kind(), v1::Integrator::TR_BDF2);
  EXPECT_EQ(integrator_message({.solver = "multigrid-cg"})->solver(), v1::Integrator::MULTIGRID_CG);
}

TEST(OfflineOverrides, LeaveTheSceneAsItIsIfANameIsUnknown) {
  scene::SheetConfig config;
  const Status applied = apply({.integrator = "bdf2", .membrane_law = "hooke"}, config);
  EXPECT_EQ(applied.error().reason, "UNKNOWN_CHOICE");
  EXPECT_EQ(applied.error().field, "membrane_law");
  EXPECT_EQ(config.integrator.kind, scene::SheetConfig().integrator.kind);
  EXPECT_FALSE(Overrides{.fidelity = "exact"}.change_integrator());
  EXPECT_TRUE(Overrides{.precision = "mixed"}.change_integrator());
}

TEST(OfflineMeshes, AreReadAsTheyAre) {
  test::MemoryDisk disk;
  ASSERT_TRUE(disk.write_file("a.obj", std::string("o caf\xe9\n") + kTriangle).ok());
  ASSERT_TRUE(disk.write_file("a.ply", std::string("ply\0\xff", 5)).ok());
  EXPECT_EQ(read_obj(disk, "a.obj")->text(), std::string("o caf\xC3\xA9\n") + kTriangle);
  EXPECT_EQ(read_ply(disk, "a.ply")->data(), std::string("ply\0\xff", 5));
  EXPECT_EQ(read_obj(disk, "b.obj").error().reason, "FILE_NOT_FOUND");
}

TEST(OfflineMeshes, MayBeCompressedOnce) {
  test::MemoryDisk disk;
  const std::string packed = drawing::gzipped(kTriangle);
  ASSERT_TRUE(disk.write_file("a.obj.gz", packed).ok());
  ASSERT_TRUE(disk.write_file("a.ply.gz", drawing::gzipped("ply\n")).ok());
  ASSERT_TRUE(disk.write_file("half", packed.substr(0, packed.size() / 2)).ok());
  ASSERT_TRUE(disk.write_file("twice", drawing::gzipped(packed)).ok());
  ASSERT_TRUE(disk.write_file("large", drawing::gzipped(std::string(scene::kMaxMeshFileBytes + 1, ' '))).ok());
  EXPECT_EQ(read_obj(disk, "a.obj.gz")->text(), kTriangle);
  EXPECT_EQ(read_ply(disk, "a.ply.gz")->data(), "ply\n");
  EXPECT_EQ(read_obj(disk, "half").error().reason, "OBJ_MALFORMED");
  EXPECT_THAT(read_ply(disk, "twice").error().message, testing::HasSubstr("compressed twice"));
  EXPECT_EQ(read_ply(disk, "large").error().reason, "PLY_TOO_LARGE");
  ASSERT_TRUE(disk.write_file("a.json", R"({"obj": {"file": "a.obj.gz"}})").ok());
  EXPECT_EQ(to_message(*read_scene(disk, "a.json")).obj().text(), kTriangle);
}

TEST(OfflineDrawings, MayBeCompressed) {
  test::MemoryDisk disk;
  const std::string packed = drawing::gzipped("0\nSECTION\n");
  ASSERT_TRUE(disk.write_file("a.dxf.gz", packed).ok());
  ASSERT_TRUE(disk.write_file("a.svgz", drawing::gzipped("<svg/>")).ok());
  EXPECT_EQ(read_drawing(disk, "a.dxf.gz", {})->dxf().data(), packed);
  EXPECT_EQ(read_drawing(disk, "a.svgz", {})->svg().text(), "<svg/>");
}

TEST(OfflineDrawings, HaveTheLimitOfAServerAndOneEncoding) {
  test::MemoryDisk disk;
  ASSERT_TRUE(disk.write_file("a.svg", "<svg/>").ok());
  ASSERT_TRUE(disk.write_file("b.svg", std::string((std::size_t{512} << 10) + 1, ' ')).ok());
  EXPECT_EQ(read_drawing(disk, "a.svg", {})->svg().text(), "<svg/>");
  EXPECT_EQ(read_drawing(disk, "b.svg", {}).error().reason, "SVG_TOO_LARGE");
  ASSERT_TRUE(disk.write_file("c", "\xef\xbb\xbf<svg id='\xf6'/>").ok());
  EXPECT_EQ(read_drawing(disk, "c", {})->svg().text(), "<svg id='\xc3\xb6'/>");
  ASSERT_TRUE(disk.write_file("d", "0\nSECTION\n").ok());
  v1::DrawingReading reading;
  reading.add_only("layer=Cut");
  EXPECT_EQ(read_drawing(disk, "d", reading)->dxf().data(), "0\nSECTION\n");
  EXPECT_EQ(read_drawing(disk, "d", reading)->dxf().reading().only(0), "layer=Cut");
}

TEST(OfflinePaths, AreParsedOrRefusedWithTheirFault) {
  const Result<v1::Path> path = parse_path("M.2.2H.8Z");
  ASSERT_TRUE(path.ok());
  ASSERT_EQ(path->subpaths_size(), 1);
  EXPECT_TRUE(path->subpaths(0).closed());
  EXPECT_EQ(parse_path("")->subpaths_size(), 0);
  EXPECT_EQ(parse_path("M0 0L1").error().reason, "SVG_PATH");
  EXPECT_FALSE(parse_path("M0 0L1").error().message.empty());
}

}  // namespace
}  // namespace kerf::offline
