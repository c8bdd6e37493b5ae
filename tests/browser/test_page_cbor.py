"""The page's decoder understands what the codec writes, and refuses what it never would."""

import base64
from typing import Any

import cbor2
import numpy as np
import pytest
from playwright.sync_api import Error, Page

from browser.show import PLACES, Script, belief, building, deployment, estimate, scan
from pilotage_schemas.codec import TAG_OF_DTYPE, encode

pytestmark = pytest.mark.browser


def read(page: Page, payload: bytes, expression: str = "value") -> Any:  # noqa: ANN401
    """Return an expression of the `value` that the page's decoder makes of `payload`."""
    body = f"""async (text) => {{
      const {{ decode }} = await import("/static/cbor.js");
      const value = decode(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)));
      return {expression};
    }}"""
    return page.evaluate(body, base64.b64encode(payload).decode())


def refusal(page: Page, payload: bytes) -> str:
    with pytest.raises(Error) as caught:
        read(page, payload)
    return str(caught.value)


@pytest.mark.parametrize(
    "value",
    [0, 23, 24, 255, 256, 65536, 2**32, 2**53, -1, -1000, 1.5, -0.25, True, False, None, "märz"],
)
def test_plain_values_arrive_as_they_were(modules: Page, value: object) -> None:
    assert read(modules, cbor2.dumps(value)) == value


@pytest.mark.parametrize("dtype", sorted(TAG_OF_DTYPE, key=str), ids=str)
def test_arrays_of_every_type_arrive(modules: Page, dtype: np.dtype[Any]) -> None:
    values = np.array([0, 1, 2, 100], dtype)
    tag = cbor2.CBORTag(TAG_OF_DTYPE[dtype], values.tobytes())
    assert read(modules, cbor2.dumps(tag), "Array.from(value)") == [0, 1, 2, 100]


def test_halves_arrive_with_sign_infinity_and_the_very_small(modules: Page) -> None:
    values = np.array([-2.5, 6e-8, 65504.0], "<f2")
    payload = cbor2.dumps(cbor2.CBORTag(84, values.tobytes()))
    assert read(modules, payload, "Array.from(value)") == pytest.approx(values.tolist())
    infinite = cbor2.dumps(cbor2.CBORTag(84, np.array([np.inf], "<f2").tobytes()))
    assert read(modules, infinite, "value[0] === Infinity") is True


def test_a_stamp_is_exact_to_a_microsecond(modules: Page) -> None:
    stamp = 1_795_370_400_123_456_789
    assert abs(read(modules, cbor2.dumps(stamp)) - stamp) < 1000


def test_messages_arrive_with_their_arrays(modules: Page) -> None:
    grid = building(5)
    payload = encode(grid)
    assert read(modules, payload, "value.cells.shape") == list(grid.cells.shape)
    assert read(modules, payload, "value.cells.data.reduce((a, b) => a + b, 0)") == grid.cells.sum()
    assert read(modules, encode(scan(5)), "value.ranges[90] === Infinity") is True
    assert read(modules, encode(belief(5, PLACES)), "value.modes.length") == 3
    pose = encode(estimate(5, Script(), (1.0, 2.0, 0.5)))
    assert read(modules, pose, "[value.pose.x, value.covariance.shape[0]]") == [1.0, 3]
    assert read(modules, encode(deployment(5, Script())), "value.processes.length") == 5


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        (b"", "cut short"),
        (b"\x19\x01", "cut short"),
        (b"\x5a\xff\xff\xff\xff", "cut short"),
        (b"\x9a\xff\xff\xff\xff", "cut short"),
        (b"\x00\x00", "left over"),
        (b"\x9f\x00\xff", "indefinite"),
        (b"\xa2\x61a\x00\x61a\x01", "twice"),
        (b"\xa1\x00\x01", "keys are text"),
        (b"\xc1\x00", "tag 1"),
        (b"\xd8\x55\x43abc", "cut short"),
        (b"\xd8\x28\x82\x81\x02\xd8\x40\x41a", "do not fill"),
        (b"\xf7", "simple value"),
        (b"\x61\xff", "UTF-8"),
        (b"\x81" * 30 + b"\x00", "too deeply"),
    ],
)
def test_what_no_sender_writes_is_refused(modules: Page, payload: bytes, reason: str) -> None:
    assert reason in refusal(modules, payload)
