"""The command `sindy fit` on the files of a case: one call, the same for all, no knowledge of the truth."""

import json
import resource
import subprocess


def command(binary, system, files, terms_file):
    """The call. Its arguments name columns and library, and nothing else."""
    call = [binary, "fit", *map(str, files), "--states", ",".join(system.states)]
    if system.inputs:
        call += ["--inputs", ",".join(system.inputs)]
    call += ["--time", "t"]
    if system.terms is None:
        call += ["--library", system.library]
    else:
        terms_file.write_text("".join(f"{term}\n" for term in system.terms))
        call += ["--terms", str(terms_file)]
    return [*call, "--json"]


def run(binary, system, files, terms_file, score, timeout_s):
    """Fits and scores: `error` (infinite where there is no model), `exact`, `cpu_s`, `note`, `choice`."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = {"error": float("inf"), "exact": False, "note": "", "choice": None}
    try:
        done = subprocess.run(
            command(binary, system, files, terms_file),
            capture_output=True, text=True, timeout=timeout_s, check=False,
        )  # fmt: skip
        try:
            answer = json.loads(done.stdout)
            equations = {
                state: {term["term"]: float(term["coefficient"]) for term in equation}
                for state, equation in answer["equations"].items()
            }
            result["error"], result["exact"] = score(equations)
            result["choice"] = answer.get("choice")
            result["note"] = answer.get("outcome", "")
        except (ValueError, KeyError, TypeError) as problem:
            told = (done.stderr.strip().splitlines() or ["nothing on stderr"])[-1]
            result["note"] = f"status {done.returncode}, {told} ({type(problem).__name__}: {problem})"
    except subprocess.TimeoutExpired:
        result["note"] = f"not done after {timeout_s} s"
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    result["cpu_s"] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return result
