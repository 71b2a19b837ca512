// Descriptions of files without a server.

#include "server/service/offline/inspect.h"

#include <string>

#include <gtest/gtest.h>

#include "server/service/drawing/inflate.h"
#include "tests/support/memory_disk.h"

namespace kerf::offline {
namespace {

constexpr const char* kApart =
    "v 0 0 0\nv 400 0 0\nv 400 0 -300\nv 0 0 0\nv 400 0 -300\nv 0 0 -300\no a\nf 1 2 3\no b\nf 4 5 6\n";

v1::InspectMeshRequest request_of(const std::string& text) {
  v1::InspectMeshRequest request;
  request.mutable_obj()->set_text(text);
  return request;
}

TEST(Inspect, KnowsAKindByContentAndThenByName) {
  test::MemoryDisk disk;
  const auto kind = [&disk](const std::string& name, const std::string& content) {
    EXPECT_TRUE(disk.write_file(name, content).ok());
    return kind_of_file(disk, name);
  };
  EXPECT_EQ(kind("a.txt", "ply\r\nformat ascii 1.0\n"), FileKind::kPly);
  EXPECT_EQ(kind("a.obj", "\xEF\xBB\xBFply\nformat"), FileKind::kPly);
  EXPECT_EQ(kind("a.ply", "v 0 0 0\n"), FileKind::kPly);
  EXPECT_EQ(kind("a", "v 0 0 0\n"), FileKind::kObj);
  EXPECT_EQ(kind("a.txt", "\xEF\xBB\xBF <?xml version=\"1.0\"?><svg/>"), FileKind::kSvg);
  EXPECT_EQ(kind("a.txt", "  0\nSECTION\n"), FileKind::kDxf);
  EXPECT_EQ(kind("a.DXF", "999\ncomment\n"), FileKind::kDxf);
  EXPECT_EQ(kind_of_file(disk, "missing.ply"), FileKind::kPly);
  // Compressed files count as what they hold, and damaged ones by their names.
  EXPECT_EQ(kind("a.gz", drawing::gzipped("ply\nformat ascii 1.0\n")), FileKind::kPly);
  EXPECT_EQ(kind("a.obj.gz", drawing::gzipped("v 0 0 0\n")), FileKind::kObj);
  EXPECT_EQ(kind("a.stl.gz", drawing::gzipped("solid a\nfacet")), FileKind::kObj);
  EXPECT_EQ(kind("a.gz", drawing::gzipped("<svg/>")), FileKind::kSvg);
  EXPECT_EQ(kind("a.gz", drawing::gzipped("0\nSECTION\n")), FileKind::kDxf);
  EXPECT_EQ(kind("drawing.svgz", "\x1f\x8b\x08"), FileKind::kSvg);
  EXPECT_EQ(kind("drawing.dxf.gz", "\x1f\x8b\x08"), FileKind::kDxf);
  EXPECT_EQ(kind("drawing.svg.gz", drawing::gzipped(drawing::gzipped("<svg/>"))), FileKind::kSvg);
  EXPECT_EQ(kind("mesh.ply.gz", "\x1f\x8b\x08"), FileKind::kPly);
  EXPECT_EQ(kind("mesh.gz", "\x1f\x8b\x08"), FileKind::kObj);
}

TEST(Inspect, DescribesTheFileAndItsSheet) {
  v1::InspectMeshRequest request = request_of(kApart);
  request.mutable_obj()->mutable_reading()->set_unit_m(1e-3);
  request.mutable_obj()->mutable_reading()->set_up_axis(v1::MeshReading::Y_UP);
  const Result<v1::MeshReport> report = inspect_mesh(request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->format(), "OBJ");
  EXPECT_EQ(report->file_vertices(), 6);
  EXPECT_EQ(report->file_faces(), 2);
  EXPECT_EQ(report->num_vertices(), 4);
  EXPECT_EQ(report->num_triangles(), 2);
  EXPECT_EQ(report->pieces(), 1);
  EXPECT_EQ(report->borders(), 1);
  EXPECT_TRUE(report->flat());
  EXPECT_FALSE(report->texture_coordinates());
  EXPECT_NEAR(report->area_m2(), 0.12, 1e-15);
  EXPECT_NEAR(report->shortest_edge_m(), 0.3, 1e-15);
  EXPECT_NEAR(report->longest_edge_m(), 0.5, 1e-15);
  EXPECT_EQ(report->extent().max().y(), 0.3);
  ASSERT_EQ(report->objects_size(), 2);
  EXPECT_EQ(report->objects(1).name(), "b");
  EXPECT_EQ(report->objects(1).faces(), 1);
  ASSERT_EQ(report->notes_size(), 1);
  EXPECT_EQ(report->faults_size(), 0);
}

TEST(Inspect, ListsFaultsOneByOne) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const v1::MeshReport words = inspect_mesh(request_of(square + "f 1 2 x\nf 1 2\nf 1 2 9\n")).value();
  ASSERT_EQ(words.faults_size(), 3);
  EXPECT_EQ(words.faults(0).find("line 5: "), 0U);
  EXPECT_EQ(words.faults(2).find("line 7: "), 0U);
  EXPECT_EQ(words.num_vertices(), 0);
  const v1::MeshReport crossed = inspect_mesh(request_of(square + "f 1 3 2 4\n")).value();
  ASSERT_EQ(crossed.faults_size(), 1);
  EXPECT_EQ(crossed.file_faces(), 1);
  EXPECT_EQ(crossed.faults(0).find("face 1 (line 5) crosses itself"), 0U);
}

TEST(Inspect, RefusesWhatIsNoMeshFile) {
  const std::string long_name = "v 0 0 0\nv 1 0 0\nv 0 1 0\no " + std::string(5000, 'n') + "\nf 1 2 3\n";
  EXPECT_EQ(inspect_mesh(request_of(long_name))->objects(0).name().size(), 1003U) << "the beginning, and dots";
  EXPECT_EQ(inspect_mesh({}).error().reason, "CHOICE_MISSING");
  EXPECT_EQ(inspect_mesh(request_of("hello\n")).error().reason, "OBJ_EMPTY");
  v1::InspectMeshRequest request;
  request.mutable_ply()->set_data("solid cube");
  EXPECT_EQ(inspect_mesh(request).error().reason, "PLY_HEADER");
  request.mutable_ply()->mutable_reading()->set_unit_m(-1.0);
  EXPECT_EQ(inspect_mesh(request).error().field, "ply.reading.unit_m");
}

}  // namespace
}  // namespace kerf::offline
