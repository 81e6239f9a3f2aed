# SPDX-License-Identifier: BSD-3-Clause
"""culm as a model of UM-Bridge (um-bridge-benchmarks.readthedocs.io), for programs that propagate
uncertainty: python3 -m culm.model_server STUDY.toml [--effect NAME.PARAMETER ...]

HTTP, protocol version 1.0, the model "culm". Input: one vector with Y in GPa, β, and the parameters
named by --effect, in their units (`culm effects NAME`). Output: one vector with b1 per cycle and b2
in Hz. The stem, the release and the effects' other parameters are those of the study file.
"""
from __future__ import annotations

import argparse
import json
import tomllib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from culm.commands import simulate
from culm.program import CulmError, InputError

MODEL = "culm"
OUTPUTS = 2
INFO = {"protocolVersion": 1.0, "models": [MODEL]}


class CulmModel:
    """b1 and b2 as a function of Y, β and parameters of effects, "quadratic_drag.drag_coefficient"."""

    def __init__(self, study: Path, parameters: list[str]):
        with study.open("rb") as stream:
            self.study = tomllib.load(stream)
        self.study.pop("factors", None)
        self.parameters = [name.split(".", 1) for name in parameters]

    @property
    def inputs(self) -> int:
        return 2 + len(self.parameters)

    def evaluate(self, values: list[float]) -> list[float]:
        values_of = {}
        for (effect, parameter), value in zip(self.parameters, values[2:]):
            values_of.setdefault(effect, []).append(f"{parameter}={float(value)!r}")
        head = dict(self.study.get("study", {}))
        kept = [name for name in head.get("effects", []) if name.split("(")[0] not in values_of]
        head["effects"] = kept + [f"{effect}({', '.join(texts)})"
                                  for effect, texts in values_of.items()]
        found = simulate({**self.study, "study": head}, values[0], values[1])
        return [found.decay_per_cycle, found.frequency_hz]


class Handler(BaseHTTPRequestHandler):
    model: CulmModel

    def do_GET(self):
        if self.path == "/Info":
            self.answer(INFO)
        else:
            self.refuse("no such address", 404)

    def do_POST(self):
        try:
            request = json.loads(self.rfile.read(int(self.headers.get("Content-Length", 0))) or "{}")
            if self.path == "/Info":
                return self.answer(INFO)
            if request.get("name") != MODEL:
                return self.refuse(f"the model is called {MODEL}", kind="ModelNotFound")
            answers = {"/InputSizes": {"inputSizes": [self.model.inputs]},
                       "/OutputSizes": {"outputSizes": [OUTPUTS]},
                       "/ModelInfo": {"support": {"Evaluate": True, "Gradient": False,
                                                  "ApplyJacobian": False, "ApplyHessian": False}}}
            if self.path in answers:
                return self.answer(answers[self.path])
            if self.path != "/Evaluate":
                return self.refuse("culm evaluates, and has no derivatives here",
                                   kind="UnsupportedFeature")
            values = request.get("input")
            if [len(vector) for vector in values] != [self.model.inputs]:
                return self.refuse(f"the input is one vector of {self.model.inputs} numbers")
            self.answer({"output": [self.model.evaluate([float(value) for value in values[0]])]})
        except (InputError, ValueError, TypeError, AttributeError) as error:
            self.refuse(str(error))
        except CulmError as error:
            self.refuse(str(error), 500, "ModelError")

    def refuse(self, message: str, status: int = 400, kind: str = "InvalidInput"):
        self.answer({"error": {"type": kind, "message": message}}, status)

    def answer(self, content: dict, status: int = 200):
        body = json.dumps(content).encode("utf-8")
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format, *arguments):
        """One line for each evaluation would hide the program that asks."""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("study", metavar="STUDY.toml", type=Path)
    parser.add_argument("--effect", metavar="NAME.PARAMETER", action="append", default=[])
    parser.add_argument("--host", default="127.0.0.1", help="address (default: this machine only)")
    parser.add_argument("--port", type=int, default=4242, help="default 4242; 0: any free one")
    arguments = parser.parse_args()
    Handler.model = CulmModel(arguments.study, arguments.effect)
    server = ThreadingHTTPServer((arguments.host, arguments.port), Handler)
    print(f"http://{arguments.host}:{server.server_address[1]}", flush=True)
    server.serve_forever()


if __name__ == "__main__":
    main()
