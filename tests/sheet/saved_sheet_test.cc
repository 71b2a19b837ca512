#include "server/core/sheet/saved_sheet.h"

#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/base/crc32c.h"
#include "server/core/sheet/sheet_fields.h"
#include "server/core/sheet/undo_history.h"
#include "tests/sheet/calls.h"
#include "tests/support/scenes.h"

namespace kerf::sheet {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::string saved(const Sheet& sheet) {
  std::string bytes;
  sheet.save([&](std::string_view part) { bytes += part; });
  return bytes;
}

std::string loading(const scene::SheetConfig& config, std::string_view bytes) {
  const Result<Sheet> sheet = Sheet::load(config, bytes);
  return sheet.ok() ? "loaded" : sheet.error().reason;
}

// A scene in which every member of a sheet has something to hold.
scene::SheetConfig with_everything() {
  scene::SheetConfig config = scenes::hanging(5);
  config.pins = {scene::RegionEdge::kTopCorners};
  scene::Constraint moving;
  moving.region = scene::RegionEdge::kLeft;
  moving.displacement = {0.0, 0.1, 0.0};
  moving.history = {{0.0, 1.0}, {0.0, 1.0}};
  config.constraints = {moving};
  config.loads = {{scene::PointForce{mesh::VertexId{8}, {0.0, 0.01, 0.0}}, {}},
                  {scene::Pressure{scene::WholeSheet{}, 0.1}, {}},
                  {scene::EdgeMoment{scene::RegionEdge::kBottom, 1e-6}, {}}};
  config.colliders = {{contact::Sphere{{0.5, 0.3, 0.2}, 0.1}, 0.4}};
  config.fidelity = scene::Fidelity::kRealTime;
  config.self_contact.thickness = 1e-3;
  config.commands = {{90, scenes::line_cut({0.1, 0.1}, {0.2, 0.2})}};
  return config;
}

// Leaves steps of cuts and resets on both sides of the history, lost pins, removed material and a grab.
Sheet busy_sheet() {
  Sheet sheet = make(with_everything());
  scene::Cut strip = scenes::line_cut({0.3, 0.2}, {0.7, 0.25});
  strip.options.width_m = 0.02;
  const std::vector<scene::Command> commands{strip,
                                             scenes::line_cut({-0.1, 0.9}, {0.3, 1.2}),
                                             scene::SetPins{{scene::RegionEdge::kTop}},
                                             scene::Reset{},
                                             scenes::circle_cut({0.5, 0.5}, 0.2),
                                             scenes::line_cut({0.1, 0.3}, {0.9, 0.35}),
                                             scene::Reset{},
                                             scenes::line_cut({-0.1, 0.3}, {1.1, 0.35}),
                                             scene::Reset{},
                                             scene::UndoCut{},
                                             scene::UndoCut{},
                                             scene::Grab{"hand", Vector2d(0.52, 0.33), std::nullopt, 0.0},
                                             scene::Drag{"hand", Vector3d(0.5, 0.1, 0.5)}};
  for (const scene::Command& command : commands) {
    const std::vector<scene::Command> one{command};
    EXPECT_TRUE(sheet.step(one).replies[0].ok());
  }
  return sheet;
}

// A sheet that lies and measures its motion, as it does before it sleeps.
Sheet resting_sheet() {
  Sheet sheet = make(scenes::lying_on_floor(3));
  run(sheet, 30);
  return sheet;
}

Sheet small_sheet() {
  Sheet sheet = make(scenes::hanging(3));
  EXPECT_TRUE(apply(sheet, scenes::line_cut({0.2, 0.5}, {0.8, 0.5})).ok());
  EXPECT_TRUE(apply(sheet, scene::Reset{}).ok());
  EXPECT_TRUE(apply(sheet, scene::UndoCut{}).ok());
  return sheet;
}

TEST(SavedSheet, IsWrittenAgainByteForByte) {
  for (const Sheet& sheet : {busy_sheet(), resting_sheet()}) {
    const std::string bytes = saved(sheet);
    Result<Sheet> loaded = Sheet::load(sheet.config(), bytes);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    EXPECT_EQ(saved(*loaded), bytes);
    EXPECT_EQ(loaded->history().bytes(), sheet.history().bytes());
    EXPECT_EQ(loaded->integrator_description(), sheet.integrator_description());
    EXPECT_EQ(loaded->expected_cost().total(), sheet.expected_cost().total());
    EXPECT_EQ(loaded->contact_phases(), sheet.contact_phases());
  }
}

TEST(SavedSheet, HasAHeaderThatSaysWhatItIs) {
  const Sheet sheet = busy_sheet();
  const Result<SavedHeader> header = read_saved_header(saved(sheet));
  ASSERT_TRUE(header.ok());
  EXPECT_EQ(header->tick, sheet.tick());
  EXPECT_EQ(header->engine, engine_hash());
  EXPECT_EQ(header->state_hash, sheet.state_hash());
  EXPECT_EQ(header->continuation_hash, sheet.continuation_hash());
}

// Flips one bit of one number at a time, and back: of each number of its own, and of the ends of each array.
class OneNumberChanged {
 public:
  static constexpr bool kReads = false;
  explicit OneNumberChanged(std::size_t which) : which_(which) {}

  template <class T>
  void plain(T* values, std::size_t n) {
    if (n > 0) touch(&values[0], sizeof(T));
    if (n > 1) touch(&values[n - 1], sizeof(T));
  }
  template <class T>
  void flag(T& value) {
    touch(&value, 1);
  }
  void presence(bool /*is_there*/) {}
  std::size_t count(std::size_t n, std::size_t /*size*/) { return n; }
  [[nodiscard]] std::size_t num_numbers() const { return number_; }

 private:
  void touch(const void* value, std::size_t size) {
    if (number_++ != which_) return;
    auto* const bytes = static_cast<unsigned char*>(const_cast<void*>(value));
    bytes[size / 2] ^= 1U;
  }

  std::size_t which_;
  std::size_t number_ = 0;
};

TEST(ContinuationHash, ChangesWithEveryNumberOfASheet) {
  for (Sheet sheet : {busy_sheet(), resting_sheet()}) {
    const std::uint64_t hash = sheet.continuation_hash();
    OneNumberChanged all(~std::size_t{0});
    visit(all, sheet);
    ASSERT_GT(all.num_numbers(), 300U);
    const std::size_t stride = 1 + all.num_numbers() / 4'000;
    for (std::size_t i = 0; i < all.num_numbers(); i += stride) {
      for (int back = 0; back < 2; ++back) {
        OneNumberChanged one(i);
        visit(one, sheet);
        ASSERT_EQ(sheet.continuation_hash() == hash, back == 1) << "number " << i;
      }
    }
  }
}

TEST(ContinuationHash, SeesWhatTheStateHashDoesNot) {
  Sheet sheet = make(scenes::hanging(5));
  Sheet other = sheet;
  ASSERT_EQ(other.continuation_hash(), sheet.continuation_hash());
  ASSERT_TRUE(apply(other, scenes::circle_cut({0.5, 0.5}, 0.2)).ok());
  ASSERT_TRUE(apply(other, scene::UndoCut{}).ok());
  EXPECT_EQ(other.state_hash(), sheet.state_hash());  // a step can be done again, and numbers are used up
  EXPECT_NE(other.continuation_hash(), sheet.continuation_hash());
  Sheet redone = other;
  ASSERT_TRUE(apply(redone, scene::RedoCut{}).ok());
  ASSERT_TRUE(apply(redone, scene::UndoCut{}).ok());
  EXPECT_EQ(redone.state_hash(), other.state_hash());  // versions have grown
  EXPECT_NE(redone.continuation_hash(), other.continuation_hash());
}

TEST(SavedSheet, IsRefusedIfAnyByteIsMissingOrAdded) {
  const Sheet sheet = small_sheet();
  const std::string bytes = saved(sheet);
  const auto shortened = [&](std::size_t size) {
    return loading(sheet.config(), std::string_view(bytes).substr(0, size));
  };
  for (std::size_t size = 0; size < 64; ++size) EXPECT_EQ(shortened(size).substr(0, 11), "SAVED_SHEET") << size;
  for (std::size_t size = 64; size < bytes.size(); ++size) ASSERT_EQ(shortened(size), "SAVED_SHEET_DAMAGED") << size;
  EXPECT_EQ(loading(sheet.config(), bytes + '\0'), "SAVED_SHEET_DAMAGED");
  EXPECT_EQ(loading(sheet.config(), bytes), "loaded");
}

TEST(SavedSheet, IsRefusedIfAnyByteIsWrong) {
  const Sheet sheet = small_sheet();
  std::string bytes = saved(sheet);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    const char byte = bytes[at];
    bytes[at] = static_cast<char>(byte ^ 1 << at % 8);
    const std::string reason = loading(sheet.config(), bytes);
    bytes[at] = byte;
    if (at < 12) {
      ASSERT_EQ(reason, "SAVED_SHEET_FORMAT") << at;
    } else {
      ASSERT_EQ(reason, "SAVED_SHEET_DAMAGED") << at;
    }
  }
}

// Makes the sums right again after a change, so that the contents themselves are looked at.
void set_sums(std::string& bytes) {
  constexpr std::size_t kHeader = 56;
  const std::uint32_t header_sum = crc32c(std::string_view(bytes).substr(0, kHeader));
  std::memcpy(bytes.data() + kHeader, &header_sum, 4);
  for (std::size_t at = kHeader + 4; at + 16 <= bytes.size();) {
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data() + at + 4, 8);
    if (length > bytes.size() - at - 16) return;
    const std::string_view rest = std::string_view(bytes).substr(at);
    const std::uint32_t sum = crc32c(rest.substr(0, 12)) ^ crc32c(rest.substr(16, length));
    std::memcpy(bytes.data() + at + 12, &sum, 4);
    at += 16 + length;
  }
}

TEST(SavedSheet, IsRefusedIfItsContentsDoNotFitItsHash) {
  const Sheet sheet = busy_sheet();
  const std::string bytes = saved(sheet);
  for (std::size_t at = 60; at < bytes.size(); at += 211) {
    for (const char byte : {'\0', '\x7f', '\xff'}) {
      std::string changed = bytes;
      if (changed[at] == byte) continue;
      changed[at] = byte;
      set_sums(changed);
      if (changed == bytes) continue;  // it was a sum
      ASSERT_EQ(loading(sheet.config(), changed), "SAVED_SHEET_DAMAGED") << at;
    }
  }
}

TEST(SavedSheet, IsRefusedForAnotherScene) {
  const Sheet sheet = busy_sheet();
  const std::string bytes = saved(sheet);
  const auto with = [&](const auto& change) {
    scene::SheetConfig config = sheet.config();
    change(config);
    return loading(config, bytes);
  };
  constexpr const char* kOther = "SAVED_SHEET_OF_ANOTHER_SCENE";
  EXPECT_EQ(with([](auto& config) { config.mesh = scene::GridSource{6, 5, 1.0, 1.0}; }), kOther);
  EXPECT_EQ(with([](auto& config) { config.material.density *= 1.01; }), kOther);
  EXPECT_EQ(with([](auto& config) { config.tick_rate_hz = 30.0; }), kOther);
  EXPECT_EQ(with([](auto& config) { config.commands.clear(); }), kOther);
  EXPECT_EQ(with([](auto& config) { std::get<contact::Sphere>(config.colliders[0].shape).radius = 0.2; }), kOther);
  EXPECT_EQ(with([](auto& config) { config.constraints[0].history.factors[1] = 2.0; }), kOther);
  EXPECT_EQ(with([](auto& config) { config.integrator.max_substeps = 100; }), kOther);
  EXPECT_EQ(with([](auto& config) { config.integrator.choice = scene::kFirstChoice; }), kOther);
  EXPECT_EQ(with([](auto& config) { config.description = "another"; }), "loaded");
}

TEST(SavedSheet, IsLoadedWithAnotherChoiceWhereNothingIsChosen) {
  scene::SheetConfig config = scenes::hanging(5);
  config.integrator.kind = scene::IntegratorKind::kTrBdf2;
  Sheet sheet = make(config);
  run(sheet, 3);
  config.integrator.choice = scene::kFirstChoice;
  EXPECT_EQ(loading(config, saved(sheet)), "loaded");
}

TEST(SavedSheet, KeepsASheetFrozen) {
  scene::SheetConfig config = scenes::hanging(20);
  config.integrator.kind = scene::IntegratorKind::kTrBdf2;
  config.integrator.solver = scene::LinearSolverKind::kDirect;
  Sheet sheet = make(config);
  const std::function<bool()> at_once = [] { return true; };
  ASSERT_TRUE(sheet.step({}, nullptr, nullptr, &at_once).gave_up);
  Result<Sheet> loaded = Sheet::load(sheet.config(), saved(sheet));
  ASSERT_TRUE(loaded.ok());
  EXPECT_TRUE(loaded->frozen());
  EXPECT_FALSE(loaded->step({}).advanced);
}

TEST(EngineHash, IsThatOfEveryBuild) {
  EXPECT_EQ(engine_hash(), 0x75494fcbca8c907eU);
}

}  // namespace
}  // namespace kerf::sheet
