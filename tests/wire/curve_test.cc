// Drawings in cuts.

#include <string>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/service/wire/command_codec.h"
#include "server/service/wire/scene_codec.h"
#include "tests/wire/scene_samples.h"

namespace kerf::wire {
namespace {

using testing::full_scene;
using ::testing::HasSubstr;

v1::Command drawing_of(const std::string& svg) {
  v1::Command command;
  command.mutable_cut()->mutable_curve()->mutable_svg()->set_text(svg);
  return command;
}

TEST(CurveCodec, DrawingsBecomePathsThatAreFitted) {
  const v1::Command drawing = drawing_of(R"(<svg viewBox="0 0 9 9"><circle r="1"/><text>a</text></svg>)");
  const Result<scene::Command> decoded_once = decode_command(drawing);
  ASSERT_TRUE(decoded_once.ok()) << decoded_once.error().message;
  const auto& cut = std::get<scene::Cut>(*decoded_once);
  EXPECT_THAT(cut.remarks, ::testing::Contains(HasSubstr("1 x text element")));
  ASSERT_TRUE(cut.options.fit.has_value());
  EXPECT_FALSE(cut.options.fit->box.has_value());
  // The form kept in recordings and by ListCuts is the same cut again.
  const v1::Command kept = encode_command(*decoded_once);
  EXPECT_TRUE(kept.cut().curve().has_path());
  EXPECT_TRUE(kept.cut().has_fit());
  EXPECT_FALSE(kept.cut().fit().has_min());
  const Result<scene::Command> decoded_again = decode_command(kept);
  ASSERT_TRUE(decoded_again.ok());
  EXPECT_EQ(encode_command(*decoded_again).SerializeAsString(), kept.SerializeAsString());
  // A box of its own stays.
  v1::Command boxed = drawing;
  *boxed.mutable_cut()->mutable_fit()->mutable_min() = v1::Vec2();
  boxed.mutable_cut()->mutable_fit()->mutable_max()->set_x(1.0);
  boxed.mutable_cut()->mutable_fit()->mutable_max()->set_y(2.0);
  const Result<scene::Command> decoded_boxed = decode_command(boxed);
  ASSERT_TRUE(decoded_boxed.ok());
  const auto& own = std::get<scene::Cut>(*decoded_boxed);
  ASSERT_TRUE(own.options.fit && own.options.fit->box);
  EXPECT_EQ(own.options.fit->box->high, Eigen::Vector2d(1.0, 2.0));
}

TEST(CurveCodec, DrawingsOfFilesNeedAReader) {
  v1::Command command;
  v1::Svg& svg = *command.mutable_cut()->mutable_curve()->mutable_svg();
  svg.set_file("leaf.svg");
  EXPECT_EQ(decode_command(command).error().reason, "SVG_FILE_REFUSED");
  EXPECT_EQ(decode_command(command).error().field, "cut.curve.svg.file");
  const FileReader reader = [](const std::string& path) -> Result<std::string> {
    if (path == "leaf.svg") return std::string("<svg><circle r='1'/></svg>");
    return Error{ErrorCode::kNotFound, "FILE_NOT_FOUND", "no such file", {}};
  };
  EXPECT_TRUE(decode_command(command, reader).ok());
  v1::Scene scene = full_scene();
  *scene.mutable_commands(0)->mutable_command() = command;
  EXPECT_TRUE(decode_scene(scene, reader).ok());
  svg.set_file("none.svg");
  EXPECT_EQ(decode_command(command, reader).error().field, "cut.curve.svg.file");
  svg.set_text("<svg/>");
  EXPECT_EQ(decode_command(command, reader).error().reason, "SVG_TWICE");
}

}  // namespace
}  // namespace kerf::wire
