#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "render/device_choice.h"

namespace kerf::render {
namespace {

using Order = std::vector<std::size_t>;

// As a machine with two cards could offer them, software first.
const std::vector<RenderDevice> kOffered{
    {"EGL device 0", "software", DeviceKind::kSoftware},
    {"EGL device 1", "/dev/dri/card0", DeviceKind::kHardware},
    {"EGL device 2", "NVIDIA, /dev/dri/renderD129", DeviceKind::kHardware},
    {"EGL surfaceless", "", DeviceKind::kUnknown},
};

Order order_for(const std::string& wish) {
  Order order;
  const Status status = devices_to_try(kOffered, wish, order);
  EXPECT_TRUE(status.ok()) << status.message;
  return order;
}

class DescribedCanvas final : public Canvas {
 public:
  explicit DescribedCanvas(std::string words) : words_(std::move(words)) {}
  Status draw(const DrawList& /*list*/, Pixels& /*pixels*/, RenderTimes* /*times*/) override { return {}; }
  [[nodiscard]] std::string description() const override { return words_; }
  [[nodiscard]] bool draws_in_software() const override { return words_ == "llvmpipe"; }

 private:
  std::string words_;
};

// Behaviour of the devices of kOffered when opened: the description of their canvas; without an entry they fail.
using Behaviour = std::map<std::size_t, std::string>;

struct Attempt {
  Status status;
  std::string canvas;  // its description; empty: none
  std::vector<DeviceOutcome> outcomes;
  Order opened;
};

Attempt attempt(const std::string& wish, const Behaviour& behaviour) {
  Attempt made;
  const auto open = [&](std::size_t device, std::unique_ptr<Canvas>& canvas) -> Status {
    made.opened.push_back(device);
    const auto at = behaviour.find(device);
    if (at == behaviour.end()) return {StatusCode::kUnavailable, "RENDERER_UNAVAILABLE", "refused", ""};
    canvas = std::make_unique<DescribedCanvas>(at->second);
    return {};
  };
  std::unique_ptr<Canvas> canvas;
  made.status = open_first(kOffered, order_for(wish), wish, open, made.outcomes, canvas);
  if (canvas != nullptr) made.canvas = canvas->description();
  return made;
}

std::vector<DeviceState> states_of(const Attempt& attempt) {
  std::vector<DeviceState> states;
  for (const DeviceOutcome& outcome : attempt.outcomes) states.push_back(outcome.state);
  return states;
}

TEST(RenderDevices, HardwareComesFirstAndUnknownOnesLast) {
  EXPECT_EQ(order_for("auto"), (Order{1, 2, 0, 3}));
  EXPECT_EQ(order_for("software"), (Order{0, 3}));
}

TEST(RenderDevices, AreForcedByNumberOrByPartOfTheirWords) {
  EXPECT_EQ(order_for("0"), (Order{0}));
  EXPECT_EQ(order_for("3"), (Order{3}));
  EXPECT_EQ(order_for("nvidia"), (Order{2}));
  EXPECT_EQ(order_for("EGL device 1"), (Order{1}));
  EXPECT_EQ(order_for("/dev/dri"), (Order{1, 2}));
  EXPECT_EQ(order_for("egl"), (Order{1, 2, 0, 3})) << "hardware first";
}

TEST(RenderDevices, UnknownOnesAreRefusedWithTheList) {
  for (const char* wish : {"4", "-1", "", "1x", "abacus", "99999999999999999999", "Auto", "none"}) {
    Order order{7};
    const Status status = devices_to_try(kOffered, wish, order);
    EXPECT_EQ(status.code, StatusCode::kInvalidArgument) << wish;
    EXPECT_EQ(status.reason, "UNKNOWN_DEVICE") << wish;
    EXPECT_EQ(status.field, "device") << wish;
    EXPECT_TRUE(order.empty()) << wish;
    EXPECT_THAT(status.message, ::testing::HasSubstr(std::string("\"") + wish + "\""));
    EXPECT_THAT(status.message, ::testing::HasSubstr("0: EGL device 0, software; 1: EGL device 1, /dev/dri/card0; "));
    EXPECT_THAT(status.message, ::testing::HasSubstr("3: EGL surfaceless"));
    EXPECT_THAT(status.message, ::testing::Not(::testing::HasSubstr("\n")));
  }
  Order order;
  EXPECT_TRUE(devices_to_try({}, "auto", order).ok()) << "nothing to try is no fault of the wish";
  EXPECT_TRUE(order.empty());
  EXPECT_THAT(devices_to_try({}, "software", order).message, ::testing::HasSubstr("EGL offers nothing"));
}

TEST(RenderDevices, TheFirstThatWorksIsChosen) {
  const Attempt made = attempt("auto", {{0, "llvmpipe"}, {2, "a card"}, {3, "llvmpipe"}});
  EXPECT_TRUE(made.status.ok());
  EXPECT_EQ(made.canvas, "a card");
  EXPECT_EQ(made.opened, (Order{1, 2}));
  EXPECT_EQ(states_of(made), (std::vector{DeviceState::kNotTried, DeviceState::kRejected, DeviceState::kChosen,
                                          DeviceState::kNotTried}));
  EXPECT_EQ(made.outcomes[1].words, "refused");
  EXPECT_EQ(made.outcomes[2].words, "a card");
  EXPECT_EQ(made.outcomes[2].device.name, "EGL device 2");
}

TEST(RenderDevices, SoftwareDrawsWhereNoCardDoes) {
  const Attempt made = attempt("auto", {{0, "llvmpipe"}, {3, "llvmpipe"}});
  EXPECT_TRUE(made.status.ok());
  EXPECT_EQ(made.opened, (Order{1, 2, 0}));
  EXPECT_EQ(made.outcomes[0].state, DeviceState::kChosen);
}

TEST(RenderDevices, ACardThatDrawsInSoftwareIsPassedOver) {
  const Behaviour behaviour{{0, "llvmpipe"}, {1, "llvmpipe"}, {2, "a card"}};
  const Attempt made = attempt("auto", behaviour);
  EXPECT_EQ(made.canvas, "a card");
  EXPECT_EQ(made.outcomes[1].state, DeviceState::kRejected);
  EXPECT_THAT(made.outcomes[1].words, ::testing::HasSubstr("software"));
  EXPECT_EQ(attempt("1", behaviour).canvas, "llvmpipe") << "unless it is what was wished";
}

TEST(RenderDevices, SoftwareWishedIsNotHardware) {
  const Attempt made = attempt("software", {{3, "a card"}});
  EXPECT_EQ(made.status.code, StatusCode::kUnavailable);
  EXPECT_EQ(made.canvas, "");
  EXPECT_THAT(made.outcomes[3].words, ::testing::HasSubstr("hardware"));
}

TEST(RenderDevices, WhereNoneWorksEachSaysWhy) {
  const Attempt made = attempt("auto", {});
  EXPECT_EQ(made.status.code, StatusCode::kUnavailable);
  EXPECT_EQ(made.status.reason, "RENDERER_UNAVAILABLE");
  EXPECT_EQ(made.status.message,
            "EGL device 1: refused; EGL device 2: refused; EGL device 0: refused; EGL surfaceless: refused");
  std::vector<DeviceOutcome> outcomes;
  std::unique_ptr<Canvas> canvas;
  const Status nothing = open_first({}, {}, "auto", nullptr, outcomes, canvas);
  EXPECT_THAT(nothing.message, ::testing::HasSubstr("apt install")) << "what to do";
}

}  // namespace
}  // namespace kerf::render
