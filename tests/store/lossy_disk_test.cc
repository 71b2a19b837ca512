// The disk that loses power: what may be lost, and what may not.

#include "tests/store/lossy_disk.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kerf::test {
namespace {

using testing::UnorderedElementsAre;

// Every content that the file may have after a loss of power; "-" if it is gone.
template <typename Change>
std::set<std::string> left_after(Change change, const std::string& path) {
  std::set<std::string> found;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    LossyDisk disk;
    disk.set_contents({{"/f/old", "before"}});
    change(disk);
    SeededRandom random(seed);
    disk.restart(random);
    const auto content = disk.read(path, 10'000);
    found.insert(content.ok() ? *content : "-");
  }
  return found;
}

TEST(LossyDisk, LosesWhatWasNotSynced) {
  const auto write = [](LossyDisk& disk) {
    auto file = disk.create("/f/new");
    ASSERT_TRUE((*file)->append("text").ok());
  };
  EXPECT_THAT(left_after(write, "/f/new"), UnorderedElementsAre("-", "", "text"));
  const auto sync = [&](LossyDisk& disk) {
    write(disk);
    ASSERT_TRUE(disk.sync_file("/f/new").ok());
  };
  EXPECT_THAT(left_after(sync, "/f/new"), UnorderedElementsAre("-", "text"));
  const auto sync_both = [&](LossyDisk& disk) {
    sync(disk);
    ASSERT_TRUE(disk.sync_folder("/f").ok());
  };
  EXPECT_THAT(left_after(sync_both, "/f/new"), UnorderedElementsAre("text"));
}

TEST(LossyDisk, TearsWritesAtSectors) {
  const std::string a(LossyDisk::kSectorBytes, 'a');
  const std::string b(LossyDisk::kSectorBytes, 'b');
  const std::string none(LossyDisk::kSectorBytes, '\0');
  const auto write = [&](LossyDisk& disk) {
    disk.set_contents({{"/f/old", ""}});
    ASSERT_EQ(disk.write_at(*disk.open("/f/old", false, nullptr), 0, a + b), LossyDisk::Outcome::kDone);
  };
  EXPECT_THAT(left_after(write, "/f/old"), UnorderedElementsAre("", a, a + b, none + b));
}

TEST(LossyDisk, LosesNamesOfFiles) {
  EXPECT_THAT(left_after([](LossyDisk& disk) { ASSERT_TRUE(disk.remove("/f/old").ok()); }, "/f/old"),
              UnorderedElementsAre("-", "before"));
  const auto rename = [](LossyDisk& disk) { ASSERT_TRUE(disk.rename("/f/old", "/f/new").ok()); };
  EXPECT_THAT(left_after(rename, "/f/new"), UnorderedElementsAre("-", "before"));
  EXPECT_THAT(left_after(rename, "/f/old"), UnorderedElementsAre("-", "before"));
}

TEST(LossyDisk, DoesNothingWithoutPower) {
  LossyDisk disk;
  disk.set_contents({{"/f/old", "before"}});
  disk.lose_power_after(2);
  EXPECT_TRUE(disk.rename("/f/old", "/f/new").ok());
  EXPECT_FALSE(disk.rename("/f/new", "/f/old").ok());
  EXPECT_FALSE(disk.create("/f/other").ok());
}

}  // namespace
}  // namespace kerf::test
