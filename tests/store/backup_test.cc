// Backups of a store that is in use.

#include <stop_token>

#include "tests/store/fixture.h"
#include "tests/support/temporary_folder.h"

namespace kerf::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

store::StoreOptions copy_options(StoreOnLossyDisk& on) {
  store::StoreOptions options = on.options();
  options.folder = "/copy";
  return options;
}

TEST(Backup, IsAStoreOfItsOwn) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  store->create(new_sheet(store->new_sheet_number()), nullptr);
  for (std::int64_t seq = 1; seq <= 200; ++seq) {
    store->append(entry(1, seq, std::string(20'000, 'x'), {request("Cut " + std::to_string(seq))}), nullptr);
  }
  store->save(state(1, 200, std::string(2'500'000, 's')), nullptr);
  ASSERT_TRUE(store->wait_until_durable().ok());
  // Each callback gives the next entry: some come while pages are copied.
  std::function<void(std::int64_t)> append = [&](std::int64_t seq) {
    store->append(entry(1, seq, std::string(3000, 'y')), [&, seq] {
      if (seq < 230) append(seq + 1);
    });
  };
  append(201);
  ASSERT_TRUE(store->backup("/copy").ok());
  SeededRandom random(3);
  while ((*store->sheets())[0].last_seq < 230) ASSERT_TRUE(store->wait_until_durable().ok());
  const auto report = store::check_store("/copy", on.disk, on.options().vfs);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_THAT(report->orphan_files, IsEmpty());
  EXPECT_GE(report->info.entries, 200);
  const auto copy = StoreOnLossyDisk::open(copy_options(on));
  EXPECT_EQ(copy->read_state(1, 200)->content.size(), 2'500'000u);
  EXPECT_EQ(copy->entries(1, 0)->front().content, std::string(20'000, 'x'));
  EXPECT_EQ(copy->requests(1000, 1'000'000)->requests.size(), 200u);
  EXPECT_EQ(store->backup("/copy").error().reason, "FOLDER_NOT_EMPTY");
}

TEST(Backup, SurvivesALossOfPower) {
  StoreOnLossyDisk on;
  {
    const auto store = on.open();
    store->create(new_sheet(store->new_sheet_number()), nullptr);
    store->save(state(1, 0, "state"), nullptr);
    ASSERT_TRUE(store->wait_until_durable().ok());
    ASSERT_TRUE(store->backup("/copy").ok());
    on.disk.lose_power_after(1);
  }
  SeededRandom random(0);
  on.disk.restart(random);
  const auto copy = StoreOnLossyDisk::open(copy_options(on));
  EXPECT_EQ(copy->read_state(1, 0)->content, "state");
}

TEST(Backup, WithADamagedStateIsRefused) {
  StoreOnLossyDisk on;
  {
    const auto store = on.open();
    store->create(new_sheet(store->new_sheet_number()), nullptr);
    store->save(state(1, 0, "state"), nullptr);
    ASSERT_TRUE(store->wait_until_durable().ok());
  }
  auto contents = on.disk.contents();
  contents["/store/states/1-0-1.state"] = "STATE";
  on.disk.set_contents(contents);
  const auto store = on.open();
  const Status refused = store->backup("/copy");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "STATE_DAMAGED");
  EXPECT_THAT(refused.error().message, HasSubstr("sheet 1: the file of the state after entry 0"));
  EXPECT_THAT(refused.error().message, HasSubstr("start kerfd again"));
  EXPECT_FALSE(on.disk.size("/copy/kerf.db").ok());
  EXPECT_THAT(on.failures(), IsEmpty());
  // One sheet that is set aside must not make a backup of all others impossible.
  ASSERT_TRUE(store->quarantine(1, "its state is damaged").ok());
  ASSERT_TRUE(store->backup("/copy").ok());
  const auto report = store::check_store("/copy", on.disk, on.options().vfs);
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_EQ(report->known_faults.size(), 1U);
}

TEST(Backup, AppearsWholeOrNotAtAll) {
  bool is_made = false;
  for (std::int64_t operations = 1; !is_made; ++operations) {
    StoreOnLossyDisk on;
    {
      const auto store = on.open();
      store->create(new_sheet(store->new_sheet_number()), nullptr);
      store->save(state(1, 0, "state"), nullptr);
      ASSERT_TRUE(store->wait_until_durable().ok());
      on.disk.lose_power_after(operations);
      is_made = store->backup("/copy").ok();
    }
    SeededRandom random(static_cast<std::uint64_t>(operations));
    on.disk.restart(random);
    const auto report = store::check_store("/copy", on.disk, on.options().vfs);
    if (!report.ok()) {
      EXPECT_EQ(report.error().reason, "STORE_NOT_FOUND") << operations;
      EXPECT_FALSE(is_made) << operations;
      continue;
    }
    EXPECT_THAT(report->faults, IsEmpty()) << operations;
    EXPECT_EQ(report->info.states, 1) << operations;
    ASSERT_LT(operations, 1000);
  }
}

TEST(Backup, ThatIsStoppedLeavesNothing) {
  StoreOnLossyDisk on;
  const auto store = on.open();
  store->create(new_sheet(store->new_sheet_number()), nullptr);
  store->save(state(1, 0, std::string(5'000'000, 's')), nullptr);
  ASSERT_TRUE(store->wait_until_durable().ok());
  std::stop_source stop;
  // Each callback gives the next entry, until one finds that the copy has begun.
  std::function<void(std::int64_t)> append = [&](std::int64_t seq) {
    store->append(entry(1, seq, "x"), [&, seq] {
      if (on.disk.size("/copy.part/kerf.db").ok()) {
        stop.request_stop();
      } else {
        append(seq + 1);
      }
    });
  };
  append(1);
  const Status outcome = store->backup("/copy", stop.get_token());
  ASSERT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.error().reason, "BACKUP_STOPPED");
  for (const auto& [path, content] : on.disk.contents()) EXPECT_NE(path.compare(0, 5, "/copy"), 0) << path;
  EXPECT_TRUE(store->backup("/copy").ok()) << "the next is made";
}

TEST(Backup, ReplacesWhatAnInterruptedOneLeft) {
  StoreOnLossyDisk on;
  auto contents = on.disk.contents();
  contents["/copy.part/kerf.db"] = "torn";
  contents["/copy.part/states/9-9-9.state"] = "torn";
  on.disk.set_contents(contents);
  const auto store = on.open();
  store->create(new_sheet(store->new_sheet_number()), nullptr);
  ASSERT_TRUE(store->backup("/copy").ok());
  const auto report = store::check_store("/copy", on.disk, on.options().vfs);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_THAT(report->faults, IsEmpty());
  EXPECT_THAT(report->orphan_files, IsEmpty());
  EXPECT_EQ(report->info.sheets, 1);
}

TEST(Backup, OfRealFiles) {
  const TemporaryFolder folder;
  store::StoreOptions options;
  options.folder = folder / "data";
  options.reserve_bytes = 0;
  options.now = [] { return std::chrono::steady_clock::now().time_since_epoch(); };
  options.unix_us = [] { return std::int64_t{1}; };
  const auto store = StoreOnLossyDisk::open(options);
  store->create(new_sheet(store->new_sheet_number()), nullptr);
  store->save(state(1, 0, "state"), nullptr);
  ASSERT_TRUE(store->wait_until_durable().ok());
  ASSERT_TRUE(store->backup(folder / "copy").ok());
  EXPECT_THAT(store::check_store(folder / "copy")->faults, IsEmpty());
  options.folder = folder / "copy";
  EXPECT_EQ(StoreOnLossyDisk::open(options)->read_state(1, 0)->content, "state");
}

}  // namespace
}  // namespace kerf::test
