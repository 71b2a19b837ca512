#include <atomic>

#include "server/service/host/admission.h"
#include "tests/host/fixture.h"

// New sheets and the load of those that run.
namespace kerf::host {
namespace {

TEST(WorkerNeed, BeginsAsWhatIsExpectedAndBecomesWhatTicksTake) {
  EXPECT_EQ(WorkerNeed::guessed_tick(1'000), 300us);
  WorkerNeed need(20ms, 300us);
  EXPECT_EQ(need.value(), 15'000);
  for (int i = 0; i < 200; ++i) need.tick_done(5ms);
  EXPECT_NEAR(static_cast<double>(need.value()), 250'000.0, 10.0);
  need.tick_done(1s);  // one slow tick is one period at most
  EXPECT_LT(need.value(), 300'000);
  for (int i = 0; i < 200; ++i) need.tick_done(1s);
  EXPECT_NEAR(static_cast<double>(need.value()), 1'000'000.0, 10.0);
  EXPECT_LE(need.value(), WorkerNeed::kWhole);
  EXPECT_EQ(WorkerNeed(20ms, 150ms).value(), WorkerNeed::kWhole);
}

TEST(Admission, ClosesAtTheLimitAndReopensWellBelowIt) {
  Admission admission(2.0);
  EXPECT_TRUE(admission.admit(1.99, 4).ok());
  const Status refused = admission.admit(2.0, 4);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "OVERLOADED");
  EXPECT_NE(refused.error().message.find("8.00 of 4 workers"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("below 7.20"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(admission.admit(1.9, 4).ok());
  EXPECT_FALSE(admission.admit(1.8, 4).ok());
  EXPECT_TRUE(admission.admit(1.79, 4).ok());
  EXPECT_TRUE(admission.admit(1.9, 4).ok());
}

TEST(Admission, OfNoLimitNeverCloses) {
  Admission admission(0.0);
  EXPECT_TRUE(admission.admit(1.0e9, 1).ok());
}

// Its sheet's ticks take as long as it says, by moving the clock within them.
class Delay : public sheet::SnapshotSink {
 public:
  explicit Delay(test::ManualClock& clock) : clock_(clock) {}
  [[nodiscard]] bool wants_snapshot() const override { return takes.load() > Nanoseconds(0); }
  void publish(std::shared_ptr<const sheet::Snapshot> /*snapshot*/) override {
    clock_.move_to(clock_.now() + takes.load());
  }
  void ended(sheet::SinkEnd /*reason*/) override {}

  std::atomic<Nanoseconds> takes{Nanoseconds(0)};

 private:
  test::ManualClock& clock_;
};

class AdmissionTest : public HostTest {
 protected:
  static HostOptions one_worker() {
    HostOptions options;
    options.workers = 1;  // which alone moves the clock while the test waits
    options.long_work = 0ms;
    options.max_load = 0.5;  // a host that is always late is never idle
    return options;
  }
  AdmissionTest() : HostTest(one_worker()) {}

  // That does not fall asleep.
  static scene::SheetConfig restless_sheet() {
    scene::SheetConfig config = small_sheet();
    config.gravity_history = {{0.0, 1.0e6}, {1.0, 1.0}};
    return config;
  }
  std::string try_to_create(const std::string& id, bool paused = false) {
    Answers<SheetStatus> answers;
    host_->create_sheet(id, restless_sheet(), paused, answers.callback());
    host_->wait_idle();
    return answers.reason(0);
  }
  std::shared_ptr<Delay> delay(const std::string& id) {
    auto sink = std::make_shared<Delay>(clock_);
    host_->add_sink(id, sink, [](const Result<Nothing>&) {});
    host_->wait_idle();
    return sink;
  }
  void done(void (Host::*change)(const std::string&, Callback<SheetStatus>), const std::string& id) {
    (host_.get()->*change)(id, [](const Result<SheetStatus>& result) { EXPECT_TRUE(result.ok()); });
    host_->wait_idle();
  }
};

TEST_F(AdmissionTest, RefusesWhileTheWorkersAreTakenAndTellsWhy) {
  create("a", restless_sheet());
  create("b", restless_sheet());
  const std::shared_ptr<Delay> a = delay("a");
  const std::shared_ptr<Delay> b = delay("b");
  run_for(4s);
  EXPECT_LT(host_->load(), 0.01);  // ticks take no time on this clock
  a->takes = 4ms;
  b->takes = 4ms;
  run_for(4s);
  EXPECT_NEAR(host_->load(), 0.4, 0.01);
  EXPECT_EQ(try_to_create("c"), "done");
  b->takes = 7ms;
  run_for(4s);
  EXPECT_NEAR(host_->load(), 0.55, 0.01);
  EXPECT_EQ(try_to_create("d"), "OVERLOADED");
  EXPECT_EQ(host_->metrics().overload_refusals, 1);
  EXPECT_EQ(try_to_create("d", true), "done");  // one that does not run takes nothing
  b->takes = Nanoseconds(5'500us);
  run_for(4s);
  EXPECT_NEAR(host_->load(), 0.475, 0.01);
  EXPECT_EQ(try_to_create("e"), "OVERLOADED");  // not yet: well below is 0.45
  b->takes = 4ms;
  run_for(4s);
  EXPECT_EQ(try_to_create("e"), "done");
}

TEST_F(AdmissionTest, OnlyWhatRunsCounts) {
  create("a", restless_sheet());
  const std::shared_ptr<Delay> a = delay("a");
  a->takes = 12ms;
  run_for(4s);
  EXPECT_NEAR(host_->load(), 0.6, 0.01);
  EXPECT_EQ(try_to_create("b"), "OVERLOADED");
  done(&Host::pause, "a");
  EXPECT_EQ(host_->load(), 0.0);
  EXPECT_EQ(try_to_create("b"), "done");
  done(&Host::resume, "a");  // a sheet that is there is not refused
  EXPECT_GT(host_->load(), 0.55);
  EXPECT_EQ(try_to_create("c"), "OVERLOADED");
  host_->delete_sheet("a", [](const Result<Nothing>& deleted) { EXPECT_TRUE(deleted.ok()); });
  host_->wait_idle();
  EXPECT_LT(host_->load(), 0.01);
  EXPECT_EQ(try_to_create("c"), "done");
}

TEST_F(AdmissionTest, SheetsThatAreBeingBuiltCountByTheirSize) {
  scene::SheetConfig quick = restless_sheet();
  quick.mesh = scenes::hanging(25).mesh;
  quick.tick_rate_hz = 1000.0;
  Answers<SheetStatus> answers;
  for (int i = 0; i < 8; ++i) {  // 625 vertices: 0.1875 of a worker each, before the first has ticked
    host_->create_sheet("s" + std::to_string(i), quick, false, answers.callback());
  }
  host_->wait_idle();
  EXPECT_EQ(host_->metrics().overload_refusals, 5);  // the three before them take 0.5625
  EXPECT_EQ(host_->metrics().sheets, 3);
  // Once built a sheet needs what its ticks are counted to take. Each has had its first tick by now, which took no time
  // on this clock and counts a sixteenth.
  const double tick_us = 1e-3 * answers.at(answers.count() - 1)->tick_estimate.cost.total();
  EXPECT_NEAR(host_->load(), 3.0 * tick_us / 1000.0 * 15 / 16, 1e-4);
}

}  // namespace
}  // namespace kerf::host
