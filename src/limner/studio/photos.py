"""Requests about photos go in: a file, a face placed by hand; what was found, or the photo itself, comes out."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from limner.errors import BadInput
from limner.studio.bodies import UPLOAD_BYTES, body, json_object
from limner.studio.openapi import BOX, POINTS, describe, ref, thing
from limner.studio.orders import NotThere
from limner.studio.studio import Studio, photo_of
from limner.studio.visitors import Visitor


@describe("Photo", body="bytes")
async def take(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Take a photo in: the bytes of its file are the body."""
    held = await studio.take(visitor, await body(request, UPLOAD_BYTES, "a photo"))
    return JSONResponse(held.about)


@describe(media="image/jpeg")
async def show(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """The photo as it is shown: upright, no larger than it is worked on."""
    return Response(photo_of(visitor, request.path_params["name"]).jpeg, media_type="image/jpeg")


@describe("Photo")
async def about(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """What was found in a photo."""
    return JSONResponse(photo_of(visitor, request.path_params["name"]).about)


@describe(status=204)
async def drop(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Let go of a photo."""
    if not visitor.photos.drop(request.path_params["name"]):
        raise NotThere("no such photo here")
    return Response(status_code=204)


@describe(thing(("face",), face=ref("Face")), body=thing(index={"type": "integer"}, points_px=POINTS, box_px=BOX))
async def place_face(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """A face by its place in the photo's faces, by 68 places, or by a box that a template is laid into."""
    held = photo_of(visitor, request.path_params["name"])
    wanted = await json_object(request)
    faces = held.about["faces"]
    if "index" in wanted:
        index = wanted["index"]
        if type(index) is not int or not 0 <= index < len(faces):
            raise BadInput(f"index: expected one of the photo's {len(faces)} faces, from 0")
        return JSONResponse({"face": faces[index]})
    size = (held.about["width"], held.about["height"])
    face = await studio.computer.ask("place", wanted=wanted, size_px=size)
    return JSONResponse({"face": face})
