#include "server/service/host/snapshot_sinks.h"

#include <memory>

#include <gtest/gtest.h>

namespace kerf::host {
namespace {

class CountingSink : public sheet::SnapshotSink {
 public:
  CountingSink(bool wants, bool strains, std::int32_t viewers) : wants_(wants), strains_(strains), viewers_(viewers) {}
  [[nodiscard]] bool wants_snapshot() const override { return wants_; }
  [[nodiscard]] bool wants_strains() const override { return strains_; }
  [[nodiscard]] std::int32_t num_viewers() const override { return viewers_; }
  void publish(std::shared_ptr<const sheet::Snapshot> /*snapshot*/) override { ++published; }
  void ended(sheet::SinkEnd /*reason*/) override {}

  int published = 0;

 private:
  bool wants_;
  bool strains_;
  std::int32_t viewers_;
};

TEST(SnapshotSinks, PublishesToThoseThatWantIt) {
  SnapshotSinks sinks;
  EXPECT_FALSE(sinks.want_snapshot());
  const auto idle = std::make_shared<CountingSink>(false, true, 2);
  const auto keen = std::make_shared<CountingSink>(true, false, 3);
  sinks.add(idle);
  EXPECT_FALSE(sinks.want_snapshot());
  sinks.add(keen);
  EXPECT_TRUE(sinks.want_snapshot());
  EXPECT_FALSE(sinks.want_strains()) << "whoever wants strains wants no snapshot";
  EXPECT_EQ(sinks.num_viewers(), 5);
  sinks.publish(std::make_shared<sheet::Snapshot>());
  EXPECT_EQ(idle->published, 0);
  EXPECT_EQ(keen->published, 1);
}

TEST(SnapshotSinks, RemovesASinkOnce) {
  SnapshotSinks sinks;
  const auto sink = std::make_shared<CountingSink>(true, true, 1);
  sinks.add(sink);
  EXPECT_TRUE(sinks.contains(sink));
  EXPECT_TRUE(sinks.want_strains());
  EXPECT_TRUE(sinks.remove(sink));
  EXPECT_FALSE(sinks.remove(sink));
  EXPECT_FALSE(sinks.contains(sink));
  sinks.add(sink);
  EXPECT_EQ(sinks.take().size(), 1U);
  EXPECT_TRUE(sinks.take().empty());
}

}  // namespace
}  // namespace kerf::host
