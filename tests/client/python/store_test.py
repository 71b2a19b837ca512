"""The store of a server: what it keeps, and a backup of it."""

import pathlib

import kerf
import support
from support import Case


class Store(Case):
    def test_a_server_without_one_says_so(self):
        for call in (self.server.store_info, self.server.prune_store, lambda: self.server.delete_set_aside(1),
                     lambda: self.server.backup_store("a")):
            self.refused(kerf.FailedPrecondition, "FAILED_PRECONDITION", "NO_STORE", "", call)

    def test_it_is_counted_pruned_and_copied(self):
        data = support.path("kept")
        process, address = support.start_server("127.0.0.1:0", "--data", data)
        self.addCleanup(support.stop_server, process)
        with kerf.connect(address) as server:
            server.create_sheet("kept", grid=(4, 4), paused=True).cut(kerf.circle((0.5, 0.5), 0.2))
            info = server.store_info()
            self.assertEqual((info.folder, info.sheets, len(info.set_aside)), (data, 1, 0))
            self.assertEqual(server.prune_store().removed_answers, 0)
            self.refused(kerf.NotFound, "NOT_FOUND", "SET_ASIDE_NOT_FOUND", "number", server.delete_set_aside, 1)
            made = server.backup_store("monday")
            self.assertGreater(made.num_bytes, 0)
            self.assertTrue(pathlib.Path(made.folder, "kerf.db").is_file())
            self.assertEqual(list(server.store_info().backup_ids), ["monday"])
            self.refused(kerf.AlreadyExists, "ALREADY_EXISTS", "BACKUP_EXISTS", "backup_id", server.backup_store, "monday")
            self.refused(kerf.InvalidArgument, "INVALID_ARGUMENT", "BACKUP_ID", "backup_id", server.backup_store, "../a")
