// Changes that wait until they are durable.
#include "server/service/host/journal.h"

#include "tests/host/fake_journal.h"
#include "tests/host/fixture.h"

namespace kerf::host {
namespace {

class JournalTest : public HostTest {
 protected:
  JournalTest() { host_ = std::make_unique<Host>(with_journal(journal_), clock_, entropy_); }
  ~JournalTest() override { host_.reset(); }  // before the journal

  [[nodiscard]] std::vector<JournalEntry> entries() const { return journal_.sheets().begin()->second.entries; }
  static scene::Cut cut() { return scenes::line_cut({-0.1, 0.5}, {0.6, 0.5}); }

  FakeJournal journal_;
};

TEST_F(JournalTest, ACutIsAnsweredAndShownOnceItIsDurable) {
  create("a", small_sheet());
  const auto sink = std::make_shared<RecordingSnapshots>();
  host_->add_sink("a", sink, [](const auto&) {});
  run_for(2 * kTick);
  const std::int32_t whole = status("a").num_vertices;
  journal_.hold();
  Answers<CommandResult> answers;
  host_->submit("a", cut(), answers.callback());
  run_for(10 * kTick);
  EXPECT_EQ(answers.count(), 0U);
  EXPECT_EQ(host_->statuses({"a"}).at(0).num_vertices, whole);
  const auto shown = sink->snapshots().size();
  EXPECT_EQ(sink->snapshots().back()->positions.cols(), whole);
  Answers<SheetStatus> read;
  host_->status("a", read.callback());
  host_->wait_idle();
  EXPECT_EQ(read.count(), 0U) << "it would show the cut";

  journal_.let_go();
  host_->wait_idle();
  ASSERT_EQ(answers.reason(0), "done");
  EXPECT_GT(read.at(0)->num_vertices, whole);
  EXPECT_GT(host_->statuses({"a"}).at(0).num_vertices, whole);
  ASSERT_EQ(sink->snapshots().size(), shown + 1) << "the newest alone was kept";
  EXPECT_EQ(sink->snapshots().back()->tick, read.at(0)->tick);
  EXPECT_EQ(read.at(0)->tick, answers.at(0)->reply.tick + 9) << "time has passed meanwhile";
}

TEST_F(JournalTest, ViewersLearnThatAChangeWaits) {
  for (const bool is_paused : {false, true}) {
    SCOPED_TRACE(is_paused);
    create("a", small_sheet(), is_paused);
    const auto sink = std::make_shared<RecordingSnapshots>();
    host_->add_sink("a", sink, [](const auto&) {});
    run_for(2 * kTick);
    const auto before = sink->snapshots();
    journal_.hold();
    host_->submit("a", cut(), [](const auto&) {});
    run_for(1300ms);
    std::vector<std::int32_t> told;
    for (const auto& snapshot : sink->snapshots()) {
      EXPECT_EQ(snapshot->positions.cols(), before.back()->positions.cols());
      EXPECT_LE(snapshot->tick, before.back()->tick);
      if (snapshot->stats.unconfirmed_ms > 0) told.push_back(snapshot->stats.unconfirmed_ms);
    }
    EXPECT_EQ(told, (std::vector<std::int32_t>{250, 500, 750, 1000, 1250}));
    journal_.let_go();
    run_for(1300ms);
    EXPECT_EQ(sink->snapshots().back()->stats.unconfirmed_ms, 0);
    EXPECT_GT(sink->snapshots().back()->positions.cols(), before.back()->positions.cols());
    const auto after = sink->snapshots().size();
    run_for(1300ms);
    EXPECT_EQ(sink->snapshots().size(), after + (is_paused ? 0 : 65)) << "nothing is repeated that does not wait";
    Answers<Nothing> deleted;
    host_->delete_sheet("a", deleted.callback());
    host_->wait_idle();
  }
}

TEST_F(JournalTest, WhatHandsDoIsShownAtOnceAndAnsweredOnceItIsDurable) {
  create("a", small_sheet());
  const auto sink = std::make_shared<RecordingSnapshots>();
  host_->add_sink("a", sink, [](const auto&) {});
  run_for(kTick);
  journal_.hold();
  Answers<CommandResult> answers;
  host_->submit("a", scene::Grab{"x", 0, std::nullopt, 0.0}, answers.callback());
  const auto shown = sink->snapshots().size();
  run_for(5 * kTick);
  EXPECT_EQ(answers.count(), 0U);
  EXPECT_EQ(sink->snapshots().size(), shown + 5);
  journal_.let_go();
  host_->wait_idle();
  EXPECT_EQ(answers.reason(0), "done");
}

TEST_F(JournalTest, ARefusalWaitsForTheChangesBeforeIt) {
  create("a", small_sheet());
  journal_.hold();
  Answers<CommandResult> answers;
  host_->submit("a", scene::UndoCut{}, answers.callback());
  run_for(2 * kTick);
  host_->submit("a", cut(), answers.callback());
  run_for(2 * kTick);
  EXPECT_EQ(answers.count(), 0U) << "the refused undo is in the journal, as in a recording";
  journal_.let_go();
  host_->wait_idle();
  EXPECT_EQ(answers.reason(0), "NOTHING_TO_UNDO");
  EXPECT_EQ(answers.reason(1), "done");
}

TEST_F(JournalTest, ASheetIsListedAndItsNameIsFreedOnceThatIsDurable) {
  journal_.hold();
  Answers<SheetStatus> made;
  host_->create_sheet("a", small_sheet(), false, made.callback());
  run_for(3 * kTick);
  EXPECT_EQ(made.count(), 0U);
  EXPECT_TRUE(host_->statuses({"a"}).empty());
  journal_.let_go();
  host_->wait_idle();
  EXPECT_EQ(made.reason(0), "done");
  EXPECT_EQ(host_->statuses({"a"}).size(), 1U);

  journal_.hold();
  Answers<Nothing> deleted;
  host_->delete_sheet("a", deleted.callback());
  run_for(3 * kTick);
  EXPECT_EQ(deleted.count(), 0U);
  Answers<SheetStatus> again;
  host_->create_sheet("a", small_sheet(), false, again.callback());
  host_->wait_idle();
  EXPECT_EQ(again.reason(0), "SHEET_EXISTS");
  journal_.let_go();
  host_->wait_idle();
  EXPECT_EQ(deleted.reason(0), "done");
  EXPECT_TRUE(journal_.sheets().empty());
  create("a", small_sheet());
}

TEST_F(JournalTest, EntriesHaveEveryChangeInOrder) {
  create("a", small_sheet(), true);
  Answers<SheetStatus> statuses;
  Answers<std::int64_t> scheduled;
  Answers<ScheduledCommand> cancelled;
  host_->schedule("a", cut(), 5, scheduled.callback());
  host_->schedule("a", scene::UndoCut{}, 6, scheduled.callback());
  host_->cancel("a", 2, cancelled.callback());
  host_->set_speed("a", 2.0, statuses.callback());
  host_->resume("a", statuses.callback());
  run_for(8 * kTick);
  host_->pause("a", statuses.callback());
  ASSERT_TRUE(submit("a", scene::UndoCut{}).ok());
  const std::vector<JournalEntry> all = entries();
  std::vector<std::size_t> kinds;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].seq, static_cast<std::int64_t>(i) + 1);
    kinds.push_back(journal_.decode(all[i]).index());
  }
  EXPECT_EQ(kinds, (std::vector<std::size_t>{3, 1, 1, 2, 3, 3, 0, 3, 0}));
  const auto done = std::get<TickEvent>(journal_.decode(all[6]));
  EXPECT_EQ(all[6].tick, 5);
  ASSERT_EQ(done.settled.size(), 1U);
  EXPECT_EQ(done.settled[0].id.number, 1);
  EXPECT_TRUE(std::get<TickEvent>(journal_.decode(all[8])).is_apply);
}

TEST_F(JournalTest, AnEntryHasTheAnswersToItsNamedRequests) {
  create("a", small_sheet());
  const auto name = std::make_shared<const NamedRequest<CommandResult>>(NamedRequest<CommandResult>{
      "Cut 1", 77, [](const CommandResult& result) { return "tick " + std::to_string(result.reply.tick); }});
  Answers<CommandResult> answers;
  host_->submit("a", cut(), answers.callback(), name);
  host_->submit("a", scene::Release{"nobody's"}, answers.callback(), name);
  run_for(2 * kTick);
  const std::vector<StoredRequest> requests = entries().at(0).requests;
  ASSERT_EQ(requests.size(), 1U) << "a refused request may be sent again";
  EXPECT_EQ(requests[0].key, "Cut 1");
  EXPECT_EQ(requests[0].body_hash, 77U);
  EXPECT_EQ(requests[0].reply, "tick " + std::to_string(answers.at(0)->reply.tick));
}

TEST_F(JournalTest, ChangesAreRefusedBeforeTheyAreDoneIfThereIsNoRoom) {
  create("a", small_sheet());
  journal_.refuse(unavailable("STORAGE_STALLED", "the disk hangs"));
  Answers<CommandResult> answers;
  Answers<std::int64_t> scheduled;
  host_->submit("a", cut(), answers.callback());
  host_->schedule("a", cut(), 50, scheduled.callback());
  host_->release_grab("a", "one that is gone");
  run_for(3 * kTick);
  EXPECT_EQ(answers.reason(0), "STORAGE_STALLED");
  EXPECT_EQ(scheduled.reason(0), "STORAGE_STALLED");
  EXPECT_EQ(entries().size(), 1U) << "hands are let go nevertheless";
}

TEST_F(JournalTest, SavedStatesAreListedOnceTheyAreDurable) {
  create("a", small_sheet());
  const auto ignore = [](const auto&) {};
  Answers<std::vector<SavedStateStatus>> listed;
  const auto list = [&] {
    host_->states("a", listed.callback());
    host_->wait_idle();
  };
  list();
  journal_.hold_states();
  host_->save_state("a", "first", false, ignore);
  host_->save_state("a", "second", false, ignore);
  list();
  EXPECT_EQ(listed.count(), 1U);
  journal_.let_go();
  host_->wait_idle();
  ASSERT_EQ(listed.count(), 2U);
  EXPECT_EQ(listed.at(1)->size(), 2U);
  journal_.hold();
  host_->delete_state("a", "first", ignore);
  list();
  EXPECT_EQ(listed.count(), 2U) << "a crash may bring it back";
  journal_.let_go();
  host_->wait_idle();
  ASSERT_EQ(listed.count(), 3U);
  EXPECT_EQ(listed.at(2)->size(), 1U);
  journal_.hold_states();
  host_->save_state("a", "third", false, ignore);
  list();
  host_->delete_sheet("a", ignore);
  host_->wait_idle();
  EXPECT_EQ(listed.reason(3), "SHEET_DELETED");
}

TEST_F(JournalTest, CallsThatWaitGetTheEndOfTheServer) {
  create("a", small_sheet());
  journal_.hold();
  Answers<CommandResult> answers;
  host_->submit("a", cut(), answers.callback());
  run_for(2 * kTick);
  host_->stop();
  EXPECT_EQ(answers.reason(0), "HOST_STOPPING") << "the change may be durable or not";
  journal_.let_go();
  EXPECT_EQ(answers.count(), 1U);
}

}  // namespace
}  // namespace kerf::host
