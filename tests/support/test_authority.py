"""An authority made for a test, with the certificates that it signs, by the command openssl."""

import pathlib
import subprocess


class Authority:
    """Files in a folder: ca.pem, and NAME.pem with NAME.key for each name() that was made."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self._openssl("-x509", "-subj", "/CN=Authority of a test", "-keyout", self._path("ca.key"), "-out", self._path("ca.pem"))
        self.ca = self._path("ca.pem")

    def make(self, name, subject_alt_name="IP:127.0.0.1,DNS:localhost"):
        """Signs a certificate. Returns the paths of it and of its key."""
        certificate, key = self._path(f"{name}.pem"), self._path(f"{name}.key")
        self._openssl("-x509", "-CA", self.ca, "-CAkey", self._path("ca.key"), "-subj", f"/CN={name}",
                      "-addext", f"subjectAltName={subject_alt_name}", "-keyout", key, "-out", certificate)
        return certificate, key

    def _path(self, name):
        return str(self.folder / name)

    @staticmethod
    def _openssl(*options):
        subprocess.run(["openssl", "req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
                        "-batch", *options], check=True, capture_output=True)
