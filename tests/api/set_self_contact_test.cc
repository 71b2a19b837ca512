// Self-contact of a live sheet, as clients change and see it.
#include <string>

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "tests/api/fixture.h"

namespace kerf::api {
namespace {

TEST_F(ApiTest, SelfContactInForceIsShownWithTheSheetUntilAReset) {
  ASSERT_TRUE(create_sheet("a", true).ok());
  const v1::Sheet before = get_sheet("sheets/a");
  const auto set = [this](const std::string& change) {
    return call_json("/kerf.v1.InteractionService/SetSheetSelfContact",
                     R"({"name":"sheets/a","set_self_contact":)" + change + "}");
  };
  ASSERT_TRUE(set(R"({"mode":"ON","thickness_m":0.002})").ok());
  ASSERT_TRUE(set(R"({"friction":0})").ok());
  const v1::Sheet sheet = get_sheet("sheets/a");
  EXPECT_EQ(sheet.scene().self_contact().mode(), v1::SelfContact::ON);
  EXPECT_EQ(sheet.scene().self_contact().friction(), 0.0);
  EXPECT_EQ(sheet.scene().self_contact().thickness_m(), 0.002);
  EXPECT_EQ(sheet.settings_version(), before.settings_version() + 2);
  ASSERT_TRUE(set(R"({"material_thickness":true})").ok());
  EXPECT_FALSE(get_sheet("sheets/a").scene().self_contact().has_thickness_m());
  EXPECT_NE(sheet.integrator().find("preferred for self-contact"), std::string::npos) << sheet.integrator();
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/ResetSheet", R"({"name":"sheets/a"})").ok());
  EXPECT_EQ(get_sheet("sheets/a").scene().SerializeAsString(), before.scene().SerializeAsString());
  EXPECT_EQ(get_sheet("sheets/a").integrator(), before.integrator());
}

TEST_F(ApiTest, SelfContactOfAPlanarSheetIsRefused) {
  const char* create = R"({"sheet_id":"i","paused":true,"scene":{"grid":{"columns":7,"rows":7,"width_m":1,"height_m":1},
    "planar":true}})";
  ASSERT_TRUE(call_json("/kerf.v1.SheetService/CreateSheet", create).ok());
  const v1::Sheet before = get_sheet("sheets/i");
  const auto refused = call_json("/kerf.v1.InteractionService/SetSheetSelfContact",
                                 R"({"name":"sheets/i","set_self_contact":{"mode":"ON","friction":0.5}})");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kFailedPrecondition);
  EXPECT_EQ(refused.error().reason, "SELF_CONTACT_PLANAR");
  EXPECT_EQ(refused.error().field, "set_self_contact.mode");
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(get_sheet("sheets/i"), before));
}

}  // namespace
}  // namespace kerf::api
