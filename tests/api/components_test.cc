// Sheets of several components, as clients make, see and cut them.
#include <string>

#include <gtest/gtest.h>

#include "tests/api/cuts_fixture.h"

namespace kerf::api {
namespace {

constexpr const char* kCreate = R"({"sheet_id":"a","paused":true,"scene":{"components":[
  {"name":"cloth","grid":{"columns":7,"rows":7,"width_m":1,"height_m":1}},
  {"name":"ribbon","grid":{"columns":7,"rows":3,"width_m":1,"height_m":0.2},"material":{"preset":"silk"}}]}})";

class ApiComponentsTest : public ApiCutsTest {
 protected:
  void SetUp() override { ASSERT_TRUE(call_json("/kerf.v1.SheetService/CreateSheet", kCreate).ok()); }
  Result<std::string> cut(const std::string& rest) {
    return call_json(
        "/kerf.v1.CutService/CreateCut",
        R"({"parent":"sheets/a","cut":{"curve":{"polyline":{"points":[{"x":-9,"y":0.1},{"x":9,"y":0.1}]}})" + rest +
            "}}");
  }
};

TEST_F(ApiComponentsTest, AreListedWithTheirPlaces) {
  const v1::Sheet sheet = get_sheet("sheets/a");
  EXPECT_EQ(sheet.num_vertices(), 49 + 21);
  ASSERT_EQ(sheet.components_size(), 2);
  EXPECT_EQ(sheet.components(1).name(), "ribbon");
  EXPECT_EQ(sheet.components(1).offset().x(), 1.1);
  EXPECT_NEAR(sheet.components(1).extent().max().y(), 0.2, 1e-15);
  EXPECT_EQ(sheet.components(1).first_vertex(), 49);
  EXPECT_EQ(sheet.components(1).num_vertices(), 21);
  ASSERT_EQ(sheet.scene().materials_size(), 1) << "a part that SetSheetMaterial can name";
  EXPECT_EQ(sheet.scene().materials(0).region().component(), "ribbon");
  EXPECT_EQ(sheet.scene().components_size(), 0) << "they are the mesh, which settings leave out";
}

TEST_F(ApiComponentsTest, AreCutAloneAndListedAsAskedFor) {
  const Result<std::string> reply = cut(R"(,"component":"ribbon")");
  ASSERT_TRUE(reply.ok()) << reply.error().message;
  EXPECT_EQ(get_sheet("sheets/a").pieces(), 3);
  const v1::ListCutsResponse cuts = list();
  ASSERT_EQ(cuts.cuts_size(), 1);
  EXPECT_EQ(cuts.cuts(0).cut().component(), "ribbon");
  EXPECT_EQ(cuts.cuts(0).cut().curve().polyline().points(0).x(), -9.0) << "in the ribbon's own coordinates";
}

TEST_F(ApiComponentsTest, OfAnotherNameAreRefused) {
  const Result<std::string> reply = cut(R"(,"component":"band")");
  ASSERT_FALSE(reply.ok());
  EXPECT_EQ(reply.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(reply.error().reason, "COMPONENT_UNKNOWN");
  EXPECT_EQ(reply.error().field, "cut.component");
  v1::CreateCutsRequest both = batch_request("sheets/a", {0.1, 0.15});
  both.mutable_cuts(1)->set_component("band");
  const Result<v1::CreateCutsResponse> refused = call(&Api::create_cuts, both);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "cuts[1].component");
  EXPECT_EQ(get_sheet("sheets/a").pieces(), 2);
}

TEST_F(ApiComponentsTest, OfMalformedScenesAreRefusedByField) {
  const auto refused = call_json("/kerf.v1.SheetService/CreateSheet", R"({"scene":{"components":[
    {"name":"cloth","grid":{"columns":1,"rows":7,"width_m":1,"height_m":1}}]}})");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "scene.components[0].grid.columns");
  EXPECT_NE(refused.error().message.find("components[0] (cloth)"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace kerf::api
