#pragma once

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <string>

#include "server/service/wire/scene_codec.h"

// Decodes messages, and compares them field by field.
namespace kerf::wire {

inline void expect_equal(const google::protobuf::Message& a, const google::protobuf::Message& b) {
  std::string difference;
  google::protobuf::util::MessageDifferencer differencer;
  differencer.ReportDifferencesToString(&difference);
  EXPECT_TRUE(differencer.Compare(a, b)) << difference;
}

inline scene::SheetConfig decoded(const v1::Scene& scene) {
  const Result<scene::SheetConfig> config = decode_scene(scene);
  EXPECT_TRUE(config.ok()) << config.error().message << " at " << config.error().field;
  return config.value();
}

}  // namespace kerf::wire
