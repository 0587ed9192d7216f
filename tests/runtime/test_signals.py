from __future__ import annotations

import os
import signal

import pytest

from mol_compactons.runtime.signals import ENDING, Interrupted, stopping_on_signals


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_waits_for_the_end_of_a_step(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    seen: list[float] = []
    with stopping_on_signals(seen.append) as watch:
        watch(1.0)
        os.kill(os.getpid(), number)
        assert seen == [1.0]
        with pytest.raises(Interrupted) as interrupt:
            watch(2.0)
    assert interrupt.value.number == number
    assert isinstance(interrupt.value, KeyboardInterrupt)
    assert seen == [1.0, 2.0]
    assert signal.getsignal(number) is before


def test_a_signal_that_is_ignored_stays_ignored() -> None:
    """As that of a closed terminal under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stopping_on_signals(lambda t: None) as watch:
            os.kill(os.getpid(), signal.SIGHUP)
            watch(1.0)
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            assert signal.getsignal(signal.SIGTERM) is not before
    finally:
        signal.signal(signal.SIGHUP, before)


def test_handlers_are_put_back_after_an_error() -> None:
    before = [signal.getsignal(number) for number in ENDING]
    with pytest.raises(ZeroDivisionError), stopping_on_signals(lambda t: None):
        raise ZeroDivisionError
    assert [signal.getsignal(number) for number in ENDING] == before
