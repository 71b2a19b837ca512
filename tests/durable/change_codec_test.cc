#include "server/service/durable/change_codec.h"

#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace kerf::durable {
namespace {

using host::SheetEvent;

SheetEvent sent(const SheetEvent& event) {
  return decode_change(encode_change(event)).value();
}

TEST(ChangeCodec, KeepsATickWithItsCommandsInOrder) {
  const host::TickEvent tick{
      {scenes::line_cut({0.0, 0.5}, {1.0, 0.5}), scene::Drag{"x", {1.0, 2.0, 3.0}}, scene::Reset{true}},
      {{1, {40, 7}}},
      {1},
      true};
  const auto got = std::get<host::TickEvent>(sent(tick));
  ASSERT_EQ(got.commands.size(), 3U);
  EXPECT_TRUE(std::holds_alternative<scene::Cut>(got.commands[0]));
  EXPECT_EQ(std::get<scene::Drag>(got.commands[1]).target.z(), 3.0);
  EXPECT_TRUE(std::get<scene::Reset>(got.commands[2]).repeats);
  ASSERT_EQ(got.settled.size(), 1U);
  EXPECT_EQ(got.settled[0].index, 1U);
  EXPECT_EQ(got.settled[0].id.at_tick, 40);
  EXPECT_EQ(got.settled[0].id.number, 7);
  EXPECT_EQ(got.of_streams, std::vector<std::size_t>{1});
  EXPECT_TRUE(got.is_apply);
  EXPECT_FALSE(std::get<host::TickEvent>(sent(host::TickEvent{})).is_apply);
}

TEST(ChangeCodec, KeepsScheduledCommandsCancellationsAndRunStates) {
  const auto scheduled = std::get<host::ScheduledCommand>(sent(host::ScheduledCommand{{90, 4}, scene::UndoCut{}}));
  EXPECT_EQ(scheduled.id.at_tick, 90);
  EXPECT_EQ(scheduled.id.number, 4);
  EXPECT_TRUE(std::holds_alternative<scene::UndoCut>(scheduled.command));
  EXPECT_EQ(std::get<host::CancelEvent>(sent(host::CancelEvent{12})).number, 12);
  const auto run = std::get<host::RunEvent>(sent(host::RunEvent{true, 0.25}));
  EXPECT_TRUE(run.is_paused);
  EXPECT_EQ(run.speed, 0.25);
}

TEST(ChangeCodec, RefusesBytesThatAreNoChange) {
  for (const std::string& bytes :
       {std::string(), std::string("\xff\xff\xff"), std::string("\x0a\x04\x12\x02\x08\x05", 6)}) {
    const Result<SheetEvent> event = decode_change(bytes);
    ASSERT_FALSE(event.ok());
    EXPECT_EQ(event.error().reason, "CHANGE_DAMAGED");
  }
}

TEST(ChangeCodec, KeepsAScene) {
  scene::SheetConfig config = scenes::hanging_with_three_cuts(9);
  config.max_vertices = 1234;
  const scene::SheetConfig got = decode_stored_scene(encode_stored_scene(config)).value();
  EXPECT_EQ(got.max_vertices, 1234);
  EXPECT_EQ(got.commands.size(), 3U);
  EXPECT_FALSE(decode_stored_scene("something").ok());
}

}  // namespace
}  // namespace kerf::durable
