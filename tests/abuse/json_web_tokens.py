"""Makes JSON Web Tokens, good ones and forged ones, with the command openssl."""

import base64
import hashlib
import hmac
import json
import subprocess


def make_key(folder, algorithm):
    """Makes a private key and the file with its public one; gives both paths."""
    folder.mkdir(exist_ok=True)
    private, public = folder / f"{algorithm}.key", folder / f"{algorithm}.pem"
    kind = ["RSA", "-pkeyopt", "rsa_keygen_bits:2048"] if algorithm == "RS256" else ["EC", "-pkeyopt", "ec_paramgen_curve:P-256"]
    openssl("genpkey", "-algorithm", *kind, "-out", private)
    openssl("pkey", "-in", private, "-pubout", "-out", public)
    return private, public


def openssl(*words, data=b""):
    return subprocess.run(["openssl", *words], input=data, capture_output=True, check=True).stdout


def coded(data):
    return base64.urlsafe_b64encode(data).rstrip(b"=").decode()


def make_token(algorithm, key, claims, signed_as=None):
    """Signs claims. `signed_as`: the algorithm that signs, where the header is to say another one."""
    text = coded(json.dumps({"alg": algorithm, "typ": "JWT"}).encode()) + "." + coded(json.dumps(claims).encode())
    return text + "." + coded(signature(signed_as or algorithm, key, text.encode()))


def signature(algorithm, key, text):
    if algorithm == "none":
        return b""
    if algorithm == "HS256":
        return hmac.new(key.read_bytes(), text, hashlib.sha256).digest()
    made = openssl("dgst", "-sha256", "-sign", key, data=text)
    return made if algorithm == "RS256" else numbers_of(made)


def numbers_of(der):
    """Gives both numbers of an ECDSA signature, 32 bytes each, as RFC 7518 wants them."""
    first = der[4:4 + der[3]]
    second = der[6 + der[3]:]
    return b"".join(number[-32:].rjust(32, b"\0") for number in (first, second))
