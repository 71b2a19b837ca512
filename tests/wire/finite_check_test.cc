#include "server/service/wire/finite_check.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/interaction.pb.h"
#include "kerf/v1/render.pb.h"
#include "kerf/v1/sheets.pb.h"
#include "kerf/v1/stream.pb.h"

namespace kerf::wire {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

// The way to a number in a message, by fields.
using Way = std::vector<const FieldDescriptor*>;

bool is_number(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE || field.cpp_type() == FieldDescriptor::CPPTYPE_FLOAT;
}

void find_numbers(const Descriptor& type, const Way& way, std::vector<Way>& found) {
  for (int i = 0; i < type.field_count(); ++i) {
    Way further = way;
    further.push_back(type.field(i));
    if (is_number(*type.field(i))) found.push_back(further);
    if (type.field(i)->message_type() != nullptr) find_numbers(*type.field(i)->message_type(), further, found);
  }
}

void set_number(Message& message, const FieldDescriptor& field, double number) {
  const Reflection& reflection = *message.GetReflection();
  const bool is_double = field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  if (field.is_repeated()) {
    is_double ? reflection.AddDouble(&message, &field, number)
              : reflection.AddFloat(&message, &field, static_cast<float>(number));
  } else {
    is_double ? reflection.SetDouble(&message, &field, number)
              : reflection.SetFloat(&message, &field, static_cast<float>(number));
  }
}

// Sets the number at the end of the way, in the second element of each list. Returns the path to it.
std::string put(Message& root, const Way& way, double number) {
  Message* message = &root;
  std::string path;
  for (const FieldDescriptor* field : way) {
    path += (path.empty() ? "" : ".") + field->name() + (field->is_repeated() ? "[1]" : "");
    if (is_number(*field)) {
      if (field->is_repeated()) set_number(*message, *field, 0.0);
      set_number(*message, *field, number);
    } else if (field->is_repeated()) {
      message->GetReflection()->AddMessage(message, field);
      message = message->GetReflection()->AddMessage(message, field);
    } else {
      message = message->GetReflection()->MutableMessage(message, field);
    }
  }
  return path;
}

class FiniteCheckTest : public ::testing::Test {
 protected:
  template <typename Request>
  static int num_numbers() {
    std::vector<Way> ways;
    find_numbers(*Request::descriptor(), {}, ways);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (const Way& way : ways) {
      for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity}) {
        Request request;
        const std::string path = put(request, way, bad);
        const Status refused = check_finite(request);
        EXPECT_FALSE(refused.ok()) << path;
        if (refused.ok()) continue;
        EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
        EXPECT_THAT(refused.error().reason, ::testing::AnyOf("NOT_FINITE", "CURVE_NOT_FINITE", "MESH_NOT_FINITE"));
        EXPECT_EQ(refused.error().field, path);
        EXPECT_NE(refused.error().message.find(path), std::string::npos);
      }
      Request request;
      put(request, way, std::numeric_limits<float>::max());
      EXPECT_TRUE(check_finite(request).ok());
    }
    return static_cast<int>(ways.size());
  }
};

TEST_F(FiniteCheckTest, NamesEachNumberOfEachRequestThatIsNotFinite) {
  EXPECT_GT(num_numbers<v1::CreateSheetRequest>(), 100);
  EXPECT_GT(num_numbers<v1::CreateCutRequest>(), 40);
  EXPECT_GT(num_numbers<v1::CreateCutsRequest>(), 40);
  EXPECT_GT(num_numbers<v1::AnalyzeSheetRequest>(), 0);
  EXPECT_GT(num_numbers<v1::UploadSheetRequest>(), 0);
  EXPECT_GT(num_numbers<v1::SetSheetSpeedRequest>(), 0);
  EXPECT_GT(num_numbers<v1::GrabPointRequest>(), 0);
  EXPECT_GT(num_numbers<v1::DragPointRequest>(), 0);
  EXPECT_GT(num_numbers<v1::SetSheetPinsRequest>(), 0);
  EXPECT_GT(num_numbers<v1::SetSheetGravityRequest>(), 0);
  EXPECT_GT(num_numbers<v1::SetSheetWindRequest>(), 0);
  EXPECT_GT(num_numbers<v1::SetSheetMaterialRequest>(), 0);
  EXPECT_GT(num_numbers<v1::SetSheetSelfContactRequest>(), 0);
  EXPECT_GT(num_numbers<v1::RenderImageRequest>(), 0);
  EXPECT_GT(num_numbers<v1::WatchImagesRequest>(), 0);
  EXPECT_GT(num_numbers<v1::SubscribeRequest>(), 0);
}

TEST_F(FiniteCheckTest, TakesRequestsWithoutNumbers) {
  EXPECT_TRUE(check_finite(v1::ListSheetsRequest()).ok());
  EXPECT_TRUE(check_finite(v1::CreateSheetRequest()).ok());
}

TEST(FiniteCheck, KeepsTheReasonsOfCurvesAndMeshes) {
  v1::CreateCutRequest cut;
  cut.mutable_cut()->mutable_curve()->mutable_circle()->set_radius_m(std::nan(""));
  EXPECT_EQ(check_finite(cut).error().reason, "CURVE_NOT_FINITE");
  EXPECT_EQ(check_finite(cut).error().field, "cut.curve.circle.radius_m");
  v1::CreateSheetRequest sheet;
  sheet.mutable_scene()->mutable_inline_()->add_material_positions(std::nan(""));
  EXPECT_EQ(check_finite(sheet).error().reason, "MESH_NOT_FINITE");
  v1::CreateSheetRequest rate;
  rate.mutable_scene()->set_tick_rate_hz(std::nan(""));
  EXPECT_EQ(check_finite(rate).error().reason, "NOT_FINITE");
}

}  // namespace
}  // namespace kerf::wire
