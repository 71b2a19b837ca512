#include <atomic>

#include "server/host/admission.h"
#include "tests/host/host_fixture.h"

// New sheets and the load of those that run.
namespace kerf::host {
namespace {

TEST(WorkerNeed, BeginsAsAGuessAndBecomesWhatTicksTake) {
  WorkerNeed need(20ms, 1'000);
  EXPECT_EQ(need.value(), 15'000);  // 1,000 * 300 ns of 20 ms
  for (int i = 0; i < 200; ++i) need.tick_done(5ms);
  EXPECT_NEAR(static_cast<double>(need.value()), 250'000.0, 10.0);
  need.tick_done(1s);  // one slow tick is one period at most
  EXPECT_LT(need.value(), 300'000);
  for (int i = 0; i < 200; ++i) need.tick_done(1s);
  EXPECT_NEAR(static_cast<double>(need.value()), 1'000'000.0, 10.0);
  EXPECT_LE(need.value(), WorkerNeed::kWhole);
  EXPECT_EQ(WorkerNeed(20ms, 500'000).value(), WorkerNeed::kWhole);
}

TEST(Admission, ClosesAtTheLimitAndReopensWellBelowIt) {
  Admission admission(2.0);
  EXPECT_TRUE(admission.admit(1.99, 4));
  const Status refused = admission.admit(2.0, 4);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(refused.error().reason, "OVERLOADED");
  EXPECT_NE(refused.error().message.find("8.00 of 4 workers"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("less than 7.20"), std::string::npos) << refused.error().message;
  EXPECT_FALSE(admission.admit(1.9, 4));
  EXPECT_FALSE(admission.admit(1.8, 4));
  EXPECT_TRUE(admission.admit(1.79, 4));
  EXPECT_TRUE(admission.admit(1.9, 4));
}

TEST(Admission, OfNoLimitNeverCloses) {
  Admission admission(0.0);
  EXPECT_TRUE(admission.admit(1.0e9, 1));
}

// Its sheet's ticks take as long as it says, by moving the clock within them.
class Delay : public sheet::SnapshotSink {
 public:
  explicit Delay(ManualClock& clock) : clock_(clock) {}
  [[nodiscard]] bool wants_snapshot() const override { return takes.load() > Nanoseconds(0); }
  void publish(std::shared_ptr<const sheet::Snapshot> /*snapshot*/) override {
    clock_.move_to(clock_.now() + takes.load());
  }
  void ended(sheet::SinkEnd /*reason*/) override {}

  std::atomic<Nanoseconds> takes{Nanoseconds(0)};

 private:
  ManualClock& clock_;
};

class AdmissionTest : public HostTest {
 protected:
  static HostOptions one_worker() {
    HostOptions options;
    options.workers = 1;  // which alone moves the clock while the test waits
    return options;
  }
  AdmissionTest() : HostTest(one_worker()) {}

  std::string try_to_create(const std::string& id, bool paused = false) {
    Answers<SheetStatus> answers;
    host_->create_sheet(id, small_sheet(), paused, answers.callback());
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
    (host_.get()->*change)(id, [](const Result<SheetStatus>& result) { EXPECT_TRUE(result); });
    host_->wait_idle();
  }
};

TEST_F(AdmissionTest, RefusesWhileTheWorkersAreTakenAndTellsWhy) {
  create("a", small_sheet());
  create("b", small_sheet());
  const std::shared_ptr<Delay> a = delay("a");
  const std::shared_ptr<Delay> b = delay("b");
  run_for(4s);
  EXPECT_LT(host_->load(), 0.01);  // ticks take no time on this clock
  a->takes = 9ms;
  b->takes = 9ms;
  run_for(4s);
  EXPECT_NEAR(host_->load(), 0.9, 0.01);
  EXPECT_EQ(try_to_create("c"), "done");
  b->takes = 15ms;  // more than there is: both slip, and each tick takes what it took
  run_for(4s);
  EXPECT_NEAR(host_->load(), 1.2, 0.01);
  EXPECT_EQ(try_to_create("d"), "OVERLOADED");
  EXPECT_EQ(host_->metrics().overload_refusals, 1);
  EXPECT_EQ(try_to_create("d", true), "done");  // one that does not run takes nothing
  b->takes = 10ms;
  run_for(4s);
  EXPECT_NEAR(host_->load(), 0.95, 0.01);
  EXPECT_EQ(try_to_create("e"), "OVERLOADED");  // not yet: well below is 0.9
  b->takes = 8ms;
  run_for(4s);
  EXPECT_EQ(try_to_create("e"), "done");
}

TEST_F(AdmissionTest, OnlyWhatRunsCounts) {
  create("a", small_sheet());
  const std::shared_ptr<Delay> a = delay("a");
  a->takes = 30ms;  // needs all of the worker
  run_for(8s);
  EXPECT_NEAR(host_->load(), 1.0, 1e-3);
  EXPECT_EQ(try_to_create("b"), "OVERLOADED");
  done(&Host::pause, "a");
  EXPECT_EQ(host_->load(), 0.0);
  EXPECT_EQ(try_to_create("b"), "done");
  done(&Host::resume, "a");  // a sheet that is there is not refused
  EXPECT_GT(host_->load(), 0.99);
  EXPECT_EQ(try_to_create("c"), "OVERLOADED");
  host_->delete_sheet("a", [](const Result<Nothing>& deleted) { EXPECT_TRUE(deleted); });
  host_->wait_idle();
  EXPECT_LT(host_->load(), 0.01);
  EXPECT_EQ(try_to_create("c"), "done");
}

TEST_F(AdmissionTest, SheetsThatAreBeingBuiltCountByTheirSize) {
  sheet::SheetConfig large = at_50_hz(scenes::hanging(100));
  Answers<SheetStatus> answers;
  for (int i = 0; i < 9; ++i) {  // 10,000 vertices: 0.15 of a worker each, before the first has ticked
    host_->create_sheet("s" + std::to_string(i), large, false, answers.callback());
  }
  EXPECT_EQ(answers.reason(0), "OVERLOADED");  // the seven before it take 1.05
  host_->wait_idle();
  EXPECT_EQ(host_->metrics().overload_refusals, 2);
  EXPECT_NEAR(host_->load(), 1.05, 1e-4);
}

}  // namespace
}  // namespace kerf::host
