#include <algorithm>
#include <utility>

#include <google/protobuf/empty.pb.h>

#include "server/service/api/core.h"
#include "server/service/api/kept_store.h"

// Implements the methods of StoreService.
namespace kerf::api {
namespace {

constexpr std::size_t kMaxBackupId = 63;

// Checks that there is a store to ask.
Status check_store(const ApiCore& core) {
  if (core.stopping) return server_stopping();
  if (core.options.store != nullptr) return Nothing{};
  return failed_precondition("NO_STORE",
                             "this server keeps no sheets, as it was started with --data none; start kerfd with "
                             "--data DIR for sheets that survive a restart");
}

Status check_backup_id(const std::string& id) {
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  const bool is_valid = !id.empty() && id.size() <= kMaxBackupId && is_plain(id.front()) &&
                        std::all_of(id.begin(), id.end(), [&](char c) { return is_plain(c) || c == '-'; });
  if (is_valid) return Nothing{};
  return invalid_argument("BACKUP_ID", "backup_id must match [a-z0-9][a-z0-9-]{0,62}", "backup_id");
}

// Runs `work` on a thread of its own, as the store waits for its disk.
template <typename Made>
void ask_store(ApiCore& core, const Reply<Made>& reply, std::function<Result<Made>()> work) {
  in_background<Made>(core.store_worker, reply, std::move(work),
                      resource_exhausted("TOO_MANY_STORE_CALLS",
                                         std::to_string(core.options.limits.max_waiting_store_calls) +
                                             " calls already wait for the store, which is the limit; try again later"));
}

}  // namespace

void Api::get_store_info(const v1::GetStoreInfoRequest& /*request*/, Reply<v1::StoreInfo> reply) {
  if (const Status ready = check_store(*core_); !ready.ok()) return reply(ready.error());
  ask_store<v1::StoreInfo>(*core_, reply, [store = core_->options.store] { return store->info(); });
}

void Api::prune_store(const v1::PruneStoreRequest& /*request*/, Reply<v1::PruneStoreResponse> reply) {
  if (const Status ready = check_store(*core_); !ready.ok()) return reply(ready.error());
  ask_store<v1::PruneStoreResponse>(*core_, reply, [store = core_->options.store] { return store->prune(); });
}

void Api::delete_set_aside_sheet(const v1::DeleteSetAsideSheetRequest& request, Reply<google::protobuf::Empty> reply) {
  if (const Status ready = check_store(*core_); !ready.ok()) return reply(ready.error());
  ask_store<google::protobuf::Empty>(
      *core_, reply, [store = core_->options.store, number = request.number()]() -> Result<google::protobuf::Empty> {
        KERF_TRY(store->delete_set_aside(number));
        return google::protobuf::Empty();
      });
}

void Api::backup_store(const v1::BackupStoreRequest& request, Reply<v1::StoreBackup> reply) {
  if (const Status ready = check_store(*core_); !ready.ok()) return reply(ready.error());
  if (const Status valid = check_backup_id(request.backup_id()); !valid.ok()) return reply(valid.error());
  if (core_->is_backing_up.exchange(true)) {
    return reply(resource_exhausted("BACKUP_UNDER_WAY", "another backup is being made; try again once it is done"));
  }
  const Reply<v1::StoreBackup> answer = [core = core_, reply = std::move(reply)](Result<v1::StoreBackup> made) {
    core->is_backing_up = false;
    reply(std::move(made));
  };
  ask_store<v1::StoreBackup>(*core_, answer, [core = core_, id = request.backup_id()]() -> Result<v1::StoreBackup> {
    Result<v1::StoreBackup> made = core->options.store->back_up(id, core->stop_backup.get_token());
    if (!made.ok() && core->stopping) return server_stopping();
    return made;
  });
}

}  // namespace kerf::api
