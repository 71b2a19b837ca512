// Opening: what is refused, and that it stays as it was. Files of the machine as well as a disk in memory.

#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>

#include "tests/store/fixture.h"
#include "tests/support/temporary_folder.h"

namespace kerf::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

store::StoreOptions real_options(const std::string& folder) {
  store::StoreOptions options;
  options.folder = folder;
  options.reserve_bytes = 1 << 20;
  options.now = [] { return std::chrono::steady_clock::now().time_since_epoch(); };
  options.unix_us = [] { return std::int64_t{1}; };
  return options;
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void run_sql(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
  sqlite3_close(database);
}

void make_store(const std::string& folder) {
  auto store = store::SqliteStore::open(real_options(folder));
  ASSERT_TRUE(store.ok()) << store.error().message;
  (*store)->create(new_sheet((*store)->new_sheet_number()), nullptr);
  EXPECT_TRUE((*store)->wait_until_durable().ok());
}

TEST(OpenStore, MakesAFolderForItsOwnerAlone) {
  const TemporaryFolder folder;
  const std::string path = folder / "data";
  make_store(path);
  struct stat about {};
  ASSERT_EQ(::stat(path.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0700U);
  EXPECT_EQ(std::filesystem::file_size(path + "/reserve"), 1U << 20U);
  const auto store = store::SqliteStore::open(real_options(path));
  EXPECT_EQ((*store)->sheets()->size(), 1u);
  EXPECT_TRUE(store::SqliteStore::open(real_options(folder / "no/such")).ok()) << "with those around it";
  EXPECT_EQ(store::SqliteStore::open(real_options(path + "/reserve/such")).error().reason, "FILE_IO");
}

TEST(OpenStore, IsRefusedWhileAnotherHasIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "data";
  {
    const auto store = store::SqliteStore::open(real_options(path));
    const auto second = store::SqliteStore::open(real_options(path));
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, ErrorCode::kFailedPrecondition);
    EXPECT_EQ(second.error().reason, "STORE_IN_USE");
    EXPECT_THAT(second.error().message, HasSubstr("process " + std::to_string(::getpid())));
    EXPECT_THAT(second.error().message, HasSubstr(path));
    EXPECT_EQ(store::check_store(path).error().reason, "STORE_IN_USE");
    std::filesystem::remove(path + "/lock");
    const auto third = store::SqliteStore::open(real_options(path));
    ASSERT_FALSE(third.ok());
    EXPECT_EQ(third.error().reason, "STORE_IN_USE");
    EXPECT_THAT(third.error().message, HasSubstr("another process uses it"));
  }
  EXPECT_TRUE(store::SqliteStore::open(real_options(path)).ok());
}

TEST(OpenStore, RefusesANewerFormat) {
  const TemporaryFolder folder;
  const std::string path = folder / "data";
  make_store(path);
  run_sql(path + "/kerf.db", "PRAGMA user_version = 2");
  const std::string before = content_of(path + "/kerf.db");
  for (const Error& error : {store::SqliteStore::open(real_options(path)).error(), store::check_store(path).error()}) {
    EXPECT_EQ(error.reason, "STORE_NEWER");
    EXPECT_THAT(error.message, HasSubstr("format 2, made by a newer Kerf; this one reads up to 1"));
  }
  EXPECT_EQ(content_of(path + "/kerf.db"), before);
}

TEST(OpenStore, RefusesAForeignFileAndLeavesIt) {
  const TemporaryFolder folder;
  const auto expect_refused = [&](const std::string& path, const std::string& reason) {
    const std::string before = content_of(path + "/kerf.db");
    EXPECT_EQ(store::SqliteStore::open(real_options(path)).error().reason, reason);
    EXPECT_EQ(store::check_store(path).error().reason, reason);
    EXPECT_EQ(content_of(path + "/kerf.db"), before);
  };
  folder.write("text/kerf.db", std::string(5000, 'x'));
  expect_refused(folder / "text", "STORE_FOREIGN");
  std::filesystem::create_directories(folder / "other");
  run_sql(folder / "other/kerf.db", "CREATE TABLE recipes(name TEXT)");
  expect_refused(folder / "other", "STORE_FOREIGN");
  make_store(folder / "changed");
  run_sql(folder / "changed/kerf.db", "ALTER TABLE journal ADD COLUMN more INTEGER");
  expect_refused(folder / "changed", "STORE_DAMAGED");
  EXPECT_EQ(store::check_store(folder / "nothing").error().reason, "STORE_NOT_FOUND");
}

TEST(OpenStore, RefusesTheRemainsOfAStore) {
  StoreOnLossyDisk on;
  {
    const auto store = on.open();
    store->create(new_sheet(store->new_sheet_number()), nullptr);
    store->save(state(1, 0, "state"), nullptr);
    EXPECT_TRUE(store->wait_until_durable().ok());
  }
  auto contents = on.disk.contents();
  for (const bool is_empty : {false, true}) {
    contents.erase("/store/kerf.db");
    if (is_empty) contents["/store/kerf.db"] = "";
    on.disk.set_contents(contents);
    const auto opened = store::SqliteStore::open(on.options());
    ASSERT_FALSE(opened.ok());
    EXPECT_EQ(opened.error().reason, "STORE_DAMAGED");
    EXPECT_THAT(opened.error().message, HasSubstr("empty or gone"));
    EXPECT_EQ(on.disk.contents(), contents);
  }
}

// A sync that fails may leave what it should have written readable until power goes.
TEST(OpenStore, DoesNotDependOnALogThatWasNeverSynced) {
  StoreOnLossyDisk on;
  Calls calls;
  {
    const auto store = on.open();
    store->create(new_sheet(store->new_sheet_number()), nullptr);
    ASSERT_TRUE(store->wait_until_durable().ok());
    on.disk.fail_syncs(true);
    store->append(entry(1, 1), calls.add("1"));
    EXPECT_FALSE(store->wait_until_durable().ok());
    EXPECT_EQ(on.failures().size(), 1u);
    store->append(entry(1, 2), calls.add("2"));
    EXPECT_EQ(store->sheets().error().reason, "STORAGE_FAILED");
    EXPECT_EQ(store->backup("/copy").error().reason, "STORAGE_FAILED");
    EXPECT_EQ(store->check_room(1).error().reason, "STORAGE_FAILED");
  }
  EXPECT_THAT(calls.names(), IsEmpty());
  EXPECT_EQ(on.failures().size(), 1u);
  on.disk.fail_syncs(false);
  std::int64_t last = 0;
  {
    const auto store = on.open();
    last = (*store->sheets())[0].last_seq + 1;
    store->append(entry(1, last), nullptr);
    ASSERT_TRUE(store->wait_until_durable().ok());
    on.disk.lose_power_after(1);
  }
  SeededRandom random(0);
  on.disk.restart(random);
  EXPECT_EQ((*on.open()->sheets())[0].last_seq, last);
  EXPECT_EQ(on.failures().size(), 1u);
}

}  // namespace
}  // namespace kerf::test
