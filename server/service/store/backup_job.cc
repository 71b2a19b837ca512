#include "server/service/store/backup_job.h"

#include <algorithm>
#include <utility>

#include "server/service/store/schema.h"

namespace kerf::store {
namespace {

constexpr int kPagesAStep = 256;  // 1 MiB

}  // namespace

BackupJob::BackupJob(Files& files, Database& source, Paths paths, std::stop_token stop,
                     std::function<void(Status)> done)
    : files_(files),
      source_(source),
      paths_(std::move(paths)),
      part_(paths_.to + ".part"),
      stop_(std::move(stop)),
      done_(std::move(done)) {}

BackupJob::~BackupJob() = default;

void BackupJob::end(const Status& status) {
  pages_.reset();
  target_.reset();
  file_.reset();
  if (!status.ok() && has_begun_) (void)files_.remove_folder(part_);  // what stays is removed by the next of its name
  done_(status);
}

Result<bool> BackupJob::advance() {
  if (is_stopped())
    return aborted("BACKUP_STOPPED", "the copy was given up, as the program ends; nothing of it is left");
  if (!target_ && !has_pages_) {
    KERF_TRY(begin());
    return false;
  }
  if (!has_pages_) {
    KERF_TRY_ASSIGN(has_pages_, copy_pages());
    return false;
  }
  if (!states_.empty()) {
    KERF_TRY(copy_state());
    return false;
  }
  KERF_TRY(finish());
  return true;
}

Status BackupJob::begin() {
  KERF_TRY_ASSIGN(const std::vector<std::string> found, files_.list(paths_.to));
  if (!found.empty()) {
    return failed_precondition("FOLDER_NOT_EMPTY", "\"" + paths_.to + "\" is not empty; name a new folder");
  }
  KERF_TRY(check_part());
  KERF_TRY(files_.remove_folder(part_));
  has_begun_ = true;
  KERF_TRY(files_.make_folder(part_));
  KERF_TRY(files_.make_folder(states_path(part_)));
  KERF_TRY_ASSIGN(Database target, Database::open(database_path(part_), paths_.vfs));
  KERF_TRY(target.execute("PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF"));
  target_.emplace(std::move(target));
  pages_.reset(sqlite3_backup_init(target_->handle(), "main", source_.handle(), "main"));
  if (pages_ == nullptr) return target_->error(sqlite3_errcode(target_->handle()), "copy");
  return Nothing{};
}

// Looks whether a folder with the name of the copy under way is the rest of another one, which may be removed.
Status BackupJob::check_part() {
  KERF_TRY_ASSIGN(const std::vector<std::string> found, files_.list(part_));
  for (const std::string& name : found) {
    if (name == "states" || name.starts_with("kerf.db")) continue;
    return failed_precondition("FOLDER_NOT_EMPTY", "\"" + part_ + "\" has other files, such as \"" + name +
                                                       "\", and the copy is made there; move it elsewhere");
  }
  return Nothing{};
}

Result<bool> BackupJob::copy_pages() {
  const int code = sqlite3_backup_step(pages_.get(), kPagesAStep);
  if (code == SQLITE_OK) return false;
  if (code != SQLITE_DONE) return target_->error(code, "copy");
  pages_.reset();
  target_.reset();
  KERF_TRY_ASSIGN(std::vector<StateRow> rows, read_state_rows(source_));
  for (StateRow& row : rows) {
    if (row.is_whole) states_.push_back(std::move(row.state));
  }
  return true;
}

Status BackupJob::copy_state() {
  const StateInfo& state = states_.back();
  if (file_ == nullptr) {
    Result<std::string> content = read_content(files_, paths_.from, state);
    if (!content.ok()) {
      KERF_TRY(check_may_be_left_out(state, content.error()));
      states_.pop_back();
      return Nothing{};
    }
    file_ = std::make_unique<FileJob>(files_, states_path(part_), file_name(state), std::move(*content));
  }
  KERF_TRY_ASSIGN(const bool is_last, file_->advance());
  if (!is_last) return Nothing{};
  file_.reset();
  states_.pop_back();
  return Nothing{};
}

// A sheet that is set aside is copied as far as it can be read: it must not make backups of all others impossible.
Status BackupJob::check_may_be_left_out(const StateInfo& state, Error error) {
  if (error.code != ErrorCode::kDataLoss) return error;
  if (paths_.takes_damaged) return Nothing{};
  KERF_TRY_ASSIGN(const std::vector<StoredSheet> sheets, read_sheets(source_));
  const auto sheet = std::find_if(sheets.begin(), sheets.end(), [&](const auto& s) { return s.sheet == state.sheet; });
  if (sheet != sheets.end() && sheet->is_quarantined) return Nothing{};
  error.message = "sheet " + std::to_string(state.sheet) + ": " + error.message +
                  "; start kerfd again, which sets it aside, and then make the backup";
  return error;
}

Status BackupJob::finish() {
  KERF_TRY(files_.sync_file(database_path(part_)));
  KERF_TRY(files_.sync_folder(part_));
  return files_.rename_folder(part_, paths_.to);
}

}  // namespace kerf::store
