#include "server/service/store/restore_store.h"

#include "server/service/store/backup_job.h"
#include "server/service/store/schema.h"

namespace kerf::store {

Result<StoreReport> restore_store(const std::string& from, const std::string& to, Files& files,
                                  const std::string& vfs) {
  KERF_TRY_ASSIGN(StoreReport report, check_store(from, files, vfs));
  if (!report.opens) {
    return data_loss("STORE_DAMAGED",
                     "\"" + from + "\" is damaged, and nothing was copied: " + report.faults.front() +
                         (report.faults.size() == 1 ? std::string()
                                                    : " (and " + std::to_string(report.faults.size() - 1) + " more)"));
  }
  KERF_TRY_ASSIGN(Database source, open_to_read(files, from, vfs));
  Status outcome = Nothing{};
  BackupJob job(files, source, {from, to, vfs, true}, {}, [&outcome](const Status& status) { outcome = status; });
  Result<bool> is_last = false;
  while (is_last.ok() && !*is_last) is_last = job.advance();
  job.end(is_last.ok() ? Status(Nothing{}) : Status(is_last.error()));
  KERF_TRY(outcome);
  return report;
}

}  // namespace kerf::store
