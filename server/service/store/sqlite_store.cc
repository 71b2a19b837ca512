#include "server/service/store/sqlite_store.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <set>
#include <thread>
#include <utility>

#include "server/base/catch_exceptions.h"
#include "server/service/store/schema.h"
#include "server/service/store/store_thread.h"

namespace kerf::store {
namespace {

// Returns true for files of states, whole or not.
bool is_state_file(const std::string& name) {
  return name.ends_with(".state") || name.ends_with(".state.new");
}

// Removes files that an end in the middle of a write left. A damaged row may have named any of them, so all stay then.
// One that cannot be removed does no harm.
Status remove_orphans(Files& files, const std::string& folder, Database& database) {
  KERF_TRY_ASSIGN(const std::vector<StateRow> states, read_state_rows(database));
  std::set<std::string> kept;
  for (const auto& [state, is_whole] : states) {
    if (!is_whole) return Nothing{};
    kept.insert(file_name(state));
  }
  KERF_TRY_ASSIGN(const std::vector<std::string> names, files.list(states_path(folder)));
  for (const std::string& name : names) {
    if (is_state_file(name) && !kept.contains(name)) (void)files.remove(states_path(folder) + "/" + name);
  }
  return Nothing{};
}

Result<std::unique_ptr<Tables>> open_tables(Files& files, const StoreOptions& options) {
  auto tables = Tables::open(files, options.folder, options.vfs, options.keep);
  if (tables.ok() || tables.error().reason != "STORAGE_FULL") return tables;
  KERF_TRY(files.remove(reserve_path(options.folder)));
  return Tables::open(files, options.folder, options.vfs, options.keep);
}

}  // namespace

struct SqliteStore::Impl {
  Impl(StoreOptions given, Files& its_files, std::unique_ptr<FileLock> its_lock, std::unique_ptr<Tables> tables)
      : options(std::move(given)),
        files(its_files),
        lock(std::move(its_lock)),
        queue(options.limits, options.now),
        next_sheet(tables->largest_sheet() + 1),
        work(options, files, queue, std::move(tables)) {}
  ~Impl() {
    queue.stop();
    if (thread.joinable()) thread.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // Runs `task` on the store's thread and returns its result.
  template <typename Task>
  std::invoke_result_t<Task> on_thread(Task task) {
    std::promise<std::invoke_result_t<Task>> promise;
    queue.push([&] {
      if (work.has_failed()) {
        promise.set_value(unavailable("STORAGE_FAILED", "the store has failed; open it once more"));
      } else {
        promise.set_value(catch_exceptions(task));
      }
    });
    return promise.get_future().get();
  }

  const StoreOptions options;
  Files& files;
  const std::unique_ptr<FileLock> lock;
  WriteQueue queue;
  std::atomic<std::int64_t> next_sheet;
  StoreThread work;
  std::thread thread;
};

Result<std::unique_ptr<SqliteStore>> SqliteStore::open(StoreOptions options) {
  Files& files = options.files == nullptr ? real_files() : *options.files;
  KERF_TRY(files.make_folder(options.folder));
  KERF_TRY(files.make_folder(states_path(options.folder)));
  KERF_TRY_ASSIGN(std::unique_ptr<FileLock> lock, files.lock(lock_path(options.folder)));
  KERF_TRY_ASSIGN(std::unique_ptr<Tables> tables, open_tables(files, options));
  KERF_TRY(remove_orphans(files, options.folder, tables->database()));
  const Result<Pruned> pruned = tables->prune(options.unix_us());
  if (!pruned.ok() && pruned.error().reason != "STORAGE_FULL") return pruned.error();
  auto impl = std::make_unique<Impl>(std::move(options), files, std::move(lock), std::move(tables));
  const Status reserved = impl->work.make_reserve();
  if (!reserved.ok() && reserved.error().reason != "DISK_FULL") return reserved.error();
  impl->queue.set_full(!reserved.ok());
  impl->thread = std::thread([work = &impl->work] { work->run(); });
  return std::unique_ptr<SqliteStore>(new SqliteStore(std::move(impl)));
}

SqliteStore::SqliteStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SqliteStore::~SqliteStore() = default;

std::int64_t SqliteStore::new_sheet_number() {
  return impl_->next_sheet++;
}

void SqliteStore::create(host::NewStoredSheet sheet, Durable durable) {
  impl_->queue.push(Change{std::move(sheet), std::move(durable)});
}

void SqliteStore::append(host::JournalEntry entry, Durable durable) {
  impl_->queue.push(Change{std::move(entry), std::move(durable)});
}

void SqliteStore::remove(std::int64_t sheet, std::vector<host::StoredRequest> requests, Durable durable) {
  impl_->queue.push(Change{Removal{sheet, std::move(requests)}, std::move(durable)});
}

void SqliteStore::save(host::StoredState state, Durable durable) {
  impl_->queue.push(StateChange{std::move(state), std::move(durable)});
}

void SqliteStore::remove_state(std::int64_t sheet, std::string name, Durable durable) {
  impl_->queue.push(Change{StateRemoval{sheet, std::move(name)}, std::move(durable)});
}

void SqliteStore::mark(std::vector<host::SheetMark> marks) {
  impl_->queue.mark(marks);
}

Status SqliteStore::check_room(std::int64_t sheet) const {
  return impl_->queue.check_room(sheet);
}

bool SqliteStore::flush(std::chrono::milliseconds limit) {
  return impl_->queue.wait_until_done(limit);
}

Status SqliteStore::wait_until_durable() {
  return impl_->queue.wait_until_done();
}

Result<std::vector<StoredSheet>> SqliteStore::sheets() {
  return impl_->on_thread([this] { return read_sheets(impl_->work.tables().database()); });
}

Result<std::vector<host::JournalEntry>> SqliteStore::entries(std::int64_t sheet, std::int64_t after_seq) {
  return impl_->on_thread([=, this] { return read_entries(impl_->work.tables().database(), sheet, after_seq); });
}

Result<KeptRequests> SqliteStore::requests(std::size_t max_count, std::size_t max_bytes) {
  return impl_->on_thread([=, this] { return read_requests(impl_->work.tables().database(), max_count, max_bytes); });
}

Result<host::StoredState> SqliteStore::read_state(std::int64_t sheet, std::int64_t seq, const std::string& name) {
  return impl_->on_thread([&]() -> Result<host::StoredState> {
    KERF_TRY_ASSIGN(const StateInfo info, read_state_row(impl_->work.tables().database(), sheet, seq, name));
    host::StoredState state;
    KERF_TRY_ASSIGN(state.content, read_content(impl_->files, impl_->options.folder, info));
    state.sheet = info.sheet;
    state.seq = info.seq;
    state.tick = info.tick;
    state.engine = info.engine;
    state.state_hash = info.state_hash;
    state.continuation_hash = info.continuation_hash;
    state.name = info.name;
    return state;
  });
}

Result<StoreInfo> SqliteStore::info() {
  return impl_->on_thread(
      [this] { return read_info(impl_->work.tables().database(), impl_->files, impl_->options.folder); });
}

Status SqliteStore::remove_entries_after(std::int64_t sheet, std::int64_t seq) {
  return impl_->on_thread([=, this] { return impl_->work.tables().remove_entries_after(sheet, seq); });
}

Status SqliteStore::quarantine(std::int64_t sheet, const std::string& reason) {
  return impl_->on_thread([&] { return impl_->work.tables().quarantine(sheet, reason); });
}

Result<std::vector<std::string>> SqliteStore::journal_faults(const StoredSheet& sheet) {
  return impl_->on_thread([&] { return store::journal_faults(impl_->work.tables().database(), sheet); });
}

Result<std::vector<DamagedState>> SqliteStore::set_damaged_states_aside(std::int64_t sheet) {
  return impl_->on_thread([=, this] {
    return store::set_damaged_states_aside(impl_->work.tables(), impl_->files, impl_->options.folder, sheet);
  });
}

Waiting SqliteStore::waiting() const {
  return impl_->queue.waiting();
}

Status SqliteStore::backup(const std::string& folder, const std::stop_token& stop) {
  std::promise<Status> promise;
  impl_->queue.push([&] {
    if (impl_->work.has_failed()) {
      promise.set_value(unavailable("STORAGE_FAILED", "the store has failed; open it once more"));
      return;
    }
    impl_->work.add(std::make_unique<BackupJob>(impl_->files, impl_->work.tables().database(),
                                                BackupJob::Paths{impl_->options.folder, folder, impl_->options.vfs},
                                                stop,
                                                [&promise](Status status) { promise.set_value(std::move(status)); }));
  });
  return promise.get_future().get();
}

Result<Pruned> SqliteStore::prune() {
  return impl_->on_thread([this] { return impl_->work.tables().prune(impl_->options.unix_us()); });
}

}  // namespace kerf::store
